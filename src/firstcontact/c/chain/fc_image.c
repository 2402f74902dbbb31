#include "fc_image.h"

#include <string.h>

#include "fc_crc32.h"
#include "fc_assert.h"
#include "fc_math.h"

static const char CUT[] = "the model is not complete";
static const char WRONG[] = "the numbers of the model do not fit together";
static const char OVERFLOWS[] = "the numbers of the model are too large";

/* Parts of an image, as chain/image.py writes them. */
typedef struct {
    char name[4];
    uint32_t version, bytes, checksum; /* checksum: of what follows */
} head;

typedef struct {
    int32_t text_bytes, model_kind;
} contents;

/* Sizes of an image without a model. */
static const fc_model_sizes NO_SIZES = {0};

typedef struct {
    const uint8_t *bytes;
    size_t left;
    bool is_cut, is_large;
} cursor;

/* Return the next array, which takes a multiple of 8 bytes. After the end, return NULL. */
static const void *take(cursor *c, int64_t count, size_t size)
{
    const void *const here = c->bytes;
    const bool fits = !c->is_cut && count >= 0 && (uint64_t)count <= c->left / size;
    const size_t bytes = fits ? ((size_t)count * size + 7) / 8 * 8 : 0;
    c->is_cut = !fits || bytes > c->left;
    if (c->is_cut)
        return NULL;
    c->bytes += bytes;
    c->left -= bytes;
    return here;
}

static const int32_t *integers(cursor *c, int64_t n)
{
    return take(c, n, sizeof(int32_t));
}

/* Return the next numbers of 4 or 8 bytes. Those that are not finite count as too large. */
static const void *reals(cursor *c, int64_t n, size_t size, double limit)
{
    const void *const x = take(c, n, size);
    const float *const single = x;
    const double *const twice = x;
    for (int64_t k = 0; x != NULL && k < n; k++)
        c->is_large |= !(fabs(size == sizeof *single ? (double)single[k] : twice[k]) < limit);
    c->is_cut |= c->is_large;
    return c->is_cut ? NULL : x;
}

static const float *floats(cursor *c, int64_t n)
{
    return reals(c, n, sizeof(float), 1e30f);
}

static const double *doubles(cursor *c, int64_t n)
{
    return reals(c, n, sizeof(double), 1e100);
}

static bool are_positive(const float *x, int32_t n)
{
    for (int32_t k = 0; k < n; k++)
        if (!(x[k] > 0.0f))
            return false;
    return true;
}

static bool ascend(const int32_t *x, int32_t n, int32_t low, int32_t high)
{
    for (int32_t k = 0; k < n; k++)
        if (x[k] < low || x[k] > high || (k > 0 && x[k] <= x[k - 1]))
            return false;
    return n > 0;
}

/* Read a matrix. `reach` is the largest magnitude of the inputs. Replace it by that of the
   outputs. */
static bool read_matrix(cursor *c, fc_matrix *m, int32_t columns, double *reach)
{
    const int32_t *const shape = integers(c, 2);
    double most = 0.0;
    if (shape == NULL || shape[0] < 1 || shape[0] > FC_WIDTH_MOST || shape[1] != columns)
        return false;
    const int32_t padded = (columns + 3) / 4 * 4;
    m->rows = shape[0];
    m->columns = columns;
    m->weight = take(c, (int64_t)m->rows * padded, sizeof *m->weight);
    m->scale = floats(c, m->rows);
    for (int32_t i = 0; !c->is_cut && i < m->rows; i++) {
        int32_t sum = 0;
        for (int32_t k = 0; k < padded; k++) {
            const int32_t weight = m->weight[i * padded + k];
            sum += weight < 0 ? -weight : weight;
            if (sum > 65535 || (k >= columns && weight != 0))
                return false;
        }
        const double out = sum * fabs((double)m->scale[i]) * *reach;
        most = out > most ? out : most;
    }
    *reach = most;
    return !c->is_cut;
}

static double largest(const float *x, int32_t n)
{
    double most = 0.0;
    for (int32_t k = 0; k < n; k++)
        most = fabs((double)x[k]) > most ? fabs((double)x[k]) : most;
    return most;
}

/* Read the network. Refuse numbers that could overflow in a prediction. */
static const char *read_network(cursor *c, fc_network *n)
{
    /* Inputs are clipped to 6. Terms of rigs are at most 1e6. */
    double reach = 6.0;
    int32_t columns = n->inputs = FC_INPUTS;
    n->mean = floats(c, FC_INPUTS);
    n->sd = floats(c, FC_INPUTS);
    if (c->is_cut || !are_positive(n->sd, FC_INPUTS))
        return WRONG;
    for (int32_t i = 0; i < FC_LAYERS; i++) {
        fc_layer *const layer = n->layers + i;
        if (!read_matrix(c, &layer->into, columns, &reach))
            return WRONG;
        reach += i == FC_RIG_LAYER ? 1e6 : 0.0;
        if (!(reach < 1e25) || !read_matrix(c, &layer->out, layer->into.rows, &reach))
            return reach < 1e25 ? WRONG : OVERFLOWS;
        columns = layer->out.rows;
        layer->bias = floats(c, columns);
        if (c->is_cut)
            return CUT;
        reach += largest(layer->bias, columns);
        if (!(reach < 1e25))
            return OVERFLOWS;
    }
    n->output = floats(c, 3 * FC_COMPONENTS * columns);
    n->output_bias = floats(c, 3 * FC_COMPONENTS);
    if (c->is_cut)
        return CUT;
    reach *= columns * largest(n->output, 3 * FC_COMPONENTS * columns);
    return reach + largest(n->output_bias, 3 * FC_COMPONENTS) < 1e25 ? NULL : OVERFLOWS;
}

static const char *read_rig(cursor *c, const fc_model *m, fc_rig *r)
{
    const fc_rig_counts *const has = r->counts = take(c, 1, sizeof *has);
    const fc_rig_scales *const f = r->scales
        = reals(c, sizeof *f / sizeof(double), sizeof(double), 1e100);
    if (c->is_cut)
        return CUT;
    const int32_t rank = m->network.layers[FC_RIG_LAYER].into.rows, n = has->pinches;
    r->rig_terms = floats(c, (int64_t)m->sizes->stages * rank);
    if (c->is_cut)
        return CUT;
    if (!(f->level >= 1e-9 && f->level <= 1e9) || fabs(f->sign) != 1.0 || n < 0
        || n > FC_PINCHES_MOST || largest(r->rig_terms, m->sizes->stages * rank) > 1e6
        || (has->has_speeds && !(f->usual_speed > 0.0 && f->speed_spread > 0.0)))
        return WRONG;
    if (has->has_pitch)
        r->reference = floats(c, FC_LINES);
    if (n > 0)
        r->processes = (const uint8_t *)floats(
            c, (int64_t)m->sizes->stages * (2 * FC_KNOWN + FC_KNOWN * n + n + n * (n + 1) / 2 + 2));
    return c->is_cut ? CUT : NULL;
}

/* Largest magnitude of the ends of an interval, which become float. */
static const double WIDEST = 1e30;

static const char *read_svm(cursor *c, const fc_model *m, int32_t samples, fc_svm *s)
{
    const fc_svm_numbers *const n = s->numbers = take(c, 1, sizeof *n);
    if (n == NULL)
        return CUT;
    const double scalars[] = {n->level, n->slope, n->gamma, n->mean, n->scale, n->lowest, n->highest};
    for (size_t k = 0; k < sizeof scalars / sizeof *scalars; k++)
        if (!(fabs(scalars[k]) < 1e100))
            return WRONG;
    if (n->guard < 0 || n->baseline < 1 || n->least < 1 || n->guard > m->sizes->before
        || n->baseline > m->sizes->before - n->guard - FC_SVM_LOOKAHEAD || n->vectors < 0
        || n->class_count < 0 || n->class_count > FC_CLASSES_MOST || n->edges < -1
        || (n->is_logarithmic != 0 && (n->is_logarithmic != 1 || n->class_count > 0))
        || !(n->gamma > 0.0 && n->gamma < 1e20) || n->lowest > n->highest
        || fabs(n->lowest) > WIDEST || fabs(n->highest) > WIDEST)
        return WRONG;
    s->samples = samples;
    s->decisions = n->class_count > 0 ? n->class_count * (n->class_count - 1) / 2 : 1;
    s->scaled = floats(c, (int64_t)n->vectors * (samples + 1));
    s->norms = floats(c, n->vectors);
    s->weights = floats(c, (int64_t)n->vectors * s->decisions);
    s->bias = floats(c, s->decisions);
    s->classes = doubles(c, n->class_count);
    s->edge = doubles(c, n->edges > 0 ? n->edges : 0);
    s->half_width = doubles(c, (int64_t)n->edges + 1);
    for (int32_t k = 0; !c->is_cut && k <= n->edges; k++)
        if (!(s->half_width[k] >= 0.0 && s->half_width[k] <= WIDEST))
            return WRONG;
    return c->is_cut ? CUT : NULL;
}

/* Read a model whose windows have several lengths: SVMs, or a model that the calling program
   computes. */
static const char *read_windows(cursor *c, fc_model *m)
{
    const fc_model_sizes *const size = m->sizes;
    const bool is_svm = m->kind == FC_MODEL_SVM;
    const char *fault = NULL;
    if (size->before < 0 || size->before > FC_CAPACITY_MOST || size->lookahead < 0
        || size->lookahead > FC_CAPACITY_MOST || size->moments < 1
        || size->moments > (is_svm ? FC_SVMS_MOST : FC_MOMENTS_MOST)
        || (is_svm && size->lookahead != FC_SVM_LOOKAHEAD))
        return WRONG;
    m->moment = integers(c, size->moments);
    if (c->is_cut)
        return CUT;
    if (!ascend(m->moment, size->moments, size->lookahead + 1, FC_CAPACITY_MOST))
        return WRONG;
    for (int32_t k = 0; is_svm && fault == NULL && k < size->moments; k++)
        fault = read_svm(c, m, m->moment[k] - FC_SVM_LOOKAHEAD, m->svm + k);
    return fault;
}

static const char *read_model(cursor *c, fc_model *m)
{
    const fc_model_sizes *const size = m->sizes = take(c, 1, sizeof *size);
    if (size == NULL)
        return CUT;
    if (m->kind != FC_MODEL_NETWORK)
        return read_windows(c, m);
    if (size->lookahead != 0 || size->before < 4 || size->before > FC_BEFORE_MOST || size->guard < 0
        || size->guard > size->before || size->baseline < 1
        || size->baseline > size->before - size->guard || size->pitch_samples < 2
        || size->pitch_samples > size->before || size->moments < 1 || size->stages < 1
        || size->rigs < 1 || size->rigs > FC_RIGS_MOST)
        return WRONG;
    m->moment = integers(c, size->moments);
    m->stage = integers(c, size->stages);
    if (c->is_cut || !ascend(m->moment, size->moments, 2, FC_POINTS)
        || !ascend(m->stage, size->stages, 1, FC_POINTS))
        return WRONG;
    m->factors = doubles(c, size->stages);
    m->familiar = floats(c, (int64_t)size->stages * FC_TRAITS);
    m->whitening = floats(c, (int64_t)size->stages * FC_TRIANGLE);
    m->limit = doubles(c, size->stages);
    const double *const step = doubles(c, 1);
    if (c->is_cut)
        return CUT;
    m->pitch_step = *step;
    const char *fault = read_network(c, &m->network);
    if (fault != NULL)
        return fault;
    m->pitch.samples = size->pitch_samples;
    m->pitch.sine = floats(c, FC_TURN / 4 + 1);
    m->pitch.fade = floats(c, m->pitch.samples);
    m->pitch.part = floats(c, FC_LINES);
    m->pitch.cell = integers(c, FC_LINES);
    for (int32_t k = 0; !c->is_cut && k < FC_LINES; k++)
        if (m->pitch.cell[k] < 0 || m->pitch.cell[k] >= FC_TURN / 2)
            return WRONG;
    bool has_any = false;
    for (int32_t k = 0; fault == NULL && k < size->rigs; k++) {
        fault = read_rig(c, m, m->rig + k);
        has_any |= fault == NULL && m->rig[k].counts->finger < 0;
    }
    return fault != NULL ? fault : has_any ? NULL : WRONG;
}

static bool is_detector(const fc_detector_constants *d)
{
    if (d->kind < FC_DETECTOR_NONE || d->kind > FC_DETECTOR_PROGRAM
        || d->window < 2 * FC_LEAST_LOUD || d->window > FC_WINDOW_MOST || d->step < 1
        || d->step > d->window || d->steady < d->window - d->step || d->steady > FC_WINDOW_MOST
        || d->search < FC_LEAST_LOUD || d->looks < 1 || d->looks > FC_LOOKS_MOST)
        return false;
    if (d->kind != FC_DETECTOR_LOGISTIC)
        return true;
    const int32_t look = d->window - (d->looks - 1) * d->step;
    return d->steady > 2 * FC_ORDER && look - FC_ORDER > d->lengths[FC_PARTS] && d->floor > 0.0
           && ascend(d->lengths, FC_PARTS + 1, 1, look);
}

/* Return true if the memory holds enough past samples for all steps of the chain. */
static bool is_long_enough(const fc_image *image)
{
    const int32_t capacity = image->timing->capacity;
    const fc_model *const m = &image->model;
    int32_t points = 0;
    if (m->kind != FC_MODEL_NONE)
        points = m->kind == FC_MODEL_NETWORK ? 2 * FC_POINTS : m->moment[m->sizes->moments - 1];
    return image->detector->window <= capacity
           && image->detector->steady <= capacity - image->timing->age
           && m->sizes->before + points <= capacity;
}

static bool is_timing(const fc_timing *t)
{
    const bool is_power = t->capacity > 0 && t->capacity <= FC_CAPACITY_MOST
                          && (t->capacity & (t->capacity - 1)) == 0;
    return is_power && t->gate_step > 0 && t->rearm >= 0 && t->every > 0 && t->age >= 0
           && t->confirmed > 0 && t->lasting > 0 && t->lasting <= t->confirmed && t->lag > 0
           && t->lag < t->confirmed && t->guard >= 0 && t->before > t->guard && t->after > 0
           && t->before < t->capacity && t->confirmed < t->capacity - t->before
           && t->age <= t->capacity;
}

const char *fc_image_read(const uint8_t *bytes, size_t n, fc_image *image)
{
    FC_ASSERT(bytes != NULL && image != NULL);
    FC_ASSERT((uintptr_t)bytes % sizeof(double) == 0);
    memset(image, 0, sizeof *image);
    cursor c = {bytes, n, false, false};
    const head *const h = take(&c, 1, sizeof *h);
    if (h == NULL || memcmp(h->name, "FCCH", sizeof h->name) != 0)
        return "this is no image of a model";
    if (h->version != FC_IMAGE_VERSION)
        return "the image of the model has another version than this program reads";
    if (h->bytes != n)
        return CUT;
    if (h->checksum != fc_crc32(c.bytes, c.left))
        return "the image of the model is damaged: its checksum differs";
    const double *const rate = doubles(&c, 1);
    image->timing = take(&c, 1, sizeof *image->timing);
    image->detector = take(&c, 1, sizeof *image->detector);
    image->floors = doubles(&c, FC_CHANNELS_MOST);
    const contents *const has = take(&c, 1, sizeof *has);
    if (c.is_cut)
        return CUT;
    image->rate = *rate;
    image->text_bytes = (uint32_t)has->text_bytes;
    image->model.kind = has->model_kind;
    image->model.sizes = &NO_SIZES;
    if (!is_timing(image->timing) || !is_detector(image->detector) || has->text_bytes < 0
        || has->text_bytes > FC_IMAGE_TEXT || has->model_kind < FC_MODEL_NONE
        || has->model_kind > FC_MODEL_SVM)
        return WRONG;
    image->text = take(&c, has->text_bytes, 1);
    const char *const fault
        = image->model.kind == FC_MODEL_NONE ? NULL : read_model(&c, &image->model);
    if (c.is_large)
        return OVERFLOWS;
    if (fault != NULL || c.is_cut)
        return fault != NULL ? fault : CUT;
    return c.left == 0 && is_long_enough(image) ? NULL : WRONG;
}
