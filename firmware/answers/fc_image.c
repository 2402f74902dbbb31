#include "fc_exact.h"
#include "fc_image.h"

#include <math.h>
#include <string.h>

#include "fc_crc32.h"
#include "fc_reach.h"

enum { INPUTS = FC_NUMBERS };

static const uint32_t sizes[] = {
    FC_WINDOW, FC_STEP, FC_STEADY, FC_SEARCH, FC_RING, FC_LOOK, FC_LOOKS, FC_QUIET, FC_ORDER,
    FC_PARTS, FC_LONGEST, FC_BEFORE, FC_BESIDE, FC_FEATURES, FC_HEADS, FC_HIDDEN, FC_FOUND,
    FC_WIDEST, FC_COMPONENTS};

static const char CUT[] = "the model is not whole", OTHER[] = "the model's numbers do not fit";

uint32_t fc_image_sizes(void)
{
    return fc_crc32((const uint8_t *)sizes, sizeof sizes);
}

typedef struct {
    const uint8_t *bytes;
    size_t left;
    bool cut;
} cursor;

/* Return the next array. Each begins at a multiple of 8 bytes. */
static const void *take(cursor *c, size_t count, size_t size)
{
    const uint8_t *const here = c->bytes;
    if (c->cut || count > (c->left / size)) {
        c->cut = true;
        return NULL;
    }
    const size_t whole = (count * size + 7) / 8 * 8;
    if (whole > c->left) {
        c->cut = true;
        return NULL;
    }
    c->bytes += whole;
    c->left -= whole;
    return here;
}

static void copy(cursor *c, void *to, size_t count, size_t size)
{
    const void *const from = take(c, count, size);
    if (from != NULL)
        memcpy(to, from, count * size);
    else
        memset(to, 0, count * size);
}

static bool finite_floats(const float *x, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!(x[k] - x[k] == 0.0f))
            return false;
    return true;
}

static bool finite_doubles(const double *x, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!(x[k] - x[k] == 0.0))
            return false;
    return true;
}

static const float *floats(cursor *c, size_t n)
{
    const float *const x = take(c, n, sizeof *x);
    if (x != NULL && !finite_floats(x, n))
        c->cut = true;
    return x;
}

static const double *doubles(cursor *c, size_t n)
{
    const double *const x = take(c, n, sizeof *x);
    if (x != NULL && !finite_doubles(x, n))
        c->cut = true;
    return x;
}

/* Read a thin layer with these inputs. Refuse it if the sum of a row could overflow 32 bits. */
static bool layer(cursor *c, fc_whole *w, int32_t inputs, int32_t most)
{
    int32_t shape[2];
    copy(c, shape, 2, sizeof *shape);
    if (c->cut || shape[1] != inputs || shape[0] < 1 || shape[0] > most)
        return false;
    const int32_t columns = (inputs + 3) / 4 * 4;
    w->outputs = shape[0];
    w->inputs = shape[1];
    w->weight = take(c, (size_t)shape[0] * (size_t)columns, sizeof *w->weight);
    w->scale = floats(c, (size_t)shape[0]);
    w->bias = floats(c, (size_t)shape[0]);
    for (int32_t i = 0; !c->cut && i < shape[0]; i++) {
        int32_t sum = 0;
        for (int32_t k = 0; k < columns; k++) {
            const int32_t weight = w->weight[i * columns + k];
            sum += weight < 0 ? -weight : weight;
        }
        if (sum > 65535)
            return false;
    }
    return !c->cut;
}

/* Read two thin layers that replace one, with a largest number of outputs. */
static bool pair(cursor *c, fc_whole *w, int32_t inputs, int32_t outputs)
{
    return layer(c, w, inputs, FC_DIRECTIONS) && layer(c, w + 1, w->outputs, outputs);
}

static bool read_judge(cursor *c, fc_loudness *j)
{
    double scalars[5];
    int32_t recent;
    copy(c, scalars, 5, sizeof *scalars);
    copy(c, &recent, 1, sizeof recent);
    j->awake = scalars[0];
    j->floor = scalars[1];
    j->ridge = scalars[2];
    j->bias = scalars[3];
    j->doubt = scalars[4];
    j->recent = recent;
    j->lengths = take(c, FC_PARTS, sizeof *j->lengths);
    j->line = doubles(c, 2 * FC_LEVELS);
    if (c->cut || recent != FC_LOOK - FC_QUIET || !finite_doubles(scalars, 5)
        || !(j->floor > 0.0) || !(j->doubt >= 0.0))
        return false;
    for (int32_t k = 0, last = 0; k < FC_PARTS; last = j->lengths[k++])
        if (j->lengths[k] <= last)
            return false;
    return j->lengths[FC_PARTS - 1] < recent;
}

static bool read_rig(cursor *c, const fc_anytime *m, fc_rig *r)
{
    int32_t told[2];
    double scalars[2];
    copy(c, told, 2, sizeof *told);
    copy(c, scalars, 2, sizeof *scalars);
    r->finger = told[0];
    r->levels = told[1];
    r->level = scalars[0];
    r->sign = scalars[1];
    r->motor = NULL; /* these kernels do not use the motor's sound */
    if (c->cut || told[1] < 0 || told[1] > FC_LEVELS_MOST || !(r->level > 1e-9)
        || !(r->level < 1e9) || (r->sign != 1.0 && r->sign != -1.0))
        return false;
    const size_t known = (size_t)m->stages * FC_FOUND * (size_t)told[1];
    r->along = floats(c, (size_t)(m->stages * m->body1[0].outputs));
    r->keys = floats(c, known);
    r->values = floats(c, known);
    return !c->cut;
}

static bool read_network(cursor *c, fc_anytime *m)
{
    enum { BODY = FC_HIDDEN + FC_FOUND, WIDE = FC_WIDEST - FC_FOUND };
    int32_t shape[2];
    m->mean = floats(c, INPUTS);
    m->each = floats(c, INPUTS);
    if (!pair(c, m->query1, INPUTS, FC_HIDDEN) || m->query1[1].outputs != FC_HIDDEN
        || !pair(c, m->query2, FC_HIDDEN, FC_FOUND) || m->query2[1].outputs != FC_FOUND
        || !pair(c, m->body1, BODY, WIDE)
        || !pair(c, m->body2, m->body1[1].outputs, WIDE)
        || !pair(c, m->body3, m->body2[1].outputs, WIDE))
        return false;
    copy(c, shape, 2, sizeof *shape);
    if (c->cut || shape[0] != 3 * FC_COMPONENTS || shape[1] != m->body3[1].outputs)
        return false;
    m->answer.outputs = shape[0];
    m->answer.inputs = shape[1];
    m->answer.weight = floats(c, (size_t)(shape[0] * shape[1]));
    m->answer.bias = floats(c, (size_t)shape[0]);
    return !c->cut;
}

static bool read_anytime(cursor *c, fc_image *image)
{
    fc_anytime *const m = &image->anytime;
    int32_t told[3];
    copy(c, told, 3, sizeof *told);
    copy(c, &m->still, 1, sizeof m->still);
    m->rigs = told[0];
    m->shortest = told[1];
    m->stages = told[2];
    if (c->cut || m->rigs < 1 || m->rigs > FC_IMAGE_RIGS || m->shortest < 2
        || m->shortest > FC_LONGEST || m->stages < 1 || m->stages > FC_LONGEST)
        return false;
    const size_t stages = (size_t)m->stages;
    m->stage = take(c, stages, sizeof *m->stage);
    m->factor = doubles(c, stages);
    m->usual = doubles(c, stages * FC_TRAITS);
    m->whitening = floats(c, stages * FC_TRAITS * FC_TRAITS);
    m->limit = doubles(c, stages);
    for (size_t k = 0; !c->cut && k < stages; k++)
        if (!(m->factor[k] > 0.0))
            return false;
    if (!read_network(c, m))
        return false;
    bool any = false;
    for (int32_t k = 0; k < m->rigs; k++) {
        if (!read_rig(c, m, image->rigs + k))
            return false;
        any |= image->rigs[k].finger < 0;
    }
    m->rig = image->rigs;
    return any;
}

/* Return true if a text is one JSON object in printable ASCII. The descriptor contains it
   unchanged. */
static bool is_object(const char *text, size_t n)
{
    int32_t depth = 0;
    bool quoted = false, escaped = false;
    for (size_t k = 0; k < n; k++) {
        const char c = text[k];
        if (c < ' ' || c > '~')
            return false;
        if (quoted) {
            quoted = escaped || c != '"';
            escaped = !escaped && c == '\\';
        } else {
            quoted = c == '"';
            depth += (c == '{') - (c == '}');
        }
        if ((depth <= 0) != (k + 1 == n))
            return false;
    }
    return text[0] == '{' && depth == 0;
}

const char *fc_image_read(const uint8_t *bytes, size_t n, fc_image *image)
{
    cursor c = {bytes, n, false};
    uint32_t head[4];
    memset(image, 0, sizeof *image);
    copy(&c, head, 4, sizeof *head);
    if (c.cut || memcmp(head, "FCMI", 4) != 0)
        return "this is no model";
    if (head[1] != FC_IMAGE_FORMAT)
        return "the model has another format than this firmware reads";
    if (head[2] != fc_image_sizes())
        return "the model is for kernels of other sizes than this firmware has";
    image->text_bytes = head[3];
    if (head[3] < 2 || head[3] > FC_IMAGE_TEXT)
        return OTHER;
    image->text = take(&c, head[3], 1);
    copy(&c, image->floors, 2, sizeof *image->floors);
    if (c.cut || !finite_doubles(image->floors, 2))
        return CUT;
    if (!is_object(image->text, image->text_bytes))
        return "the model's text cannot be told";
    image->gated = image->floors[0] > 0.0 && image->floors[1] > 0.0;
    if (!read_judge(&c, &image->judge) || !read_anytime(&c, image))
        return c.cut ? CUT : OTHER;
    if (c.left != 0)
        return OTHER;
    return fc_reach_is_bounded(&image->anytime) ? NULL : "the model's numbers are too large";
}
