/* Predict with the first SVM of an image. Input: the length of the image and its bytes; then, for each
   contact, the number of samples, the number of those before the contact, and the samples in volts
   (double). Output: one record per contact. */
#include "machine.h"

#include <string.h>

#include "fc_chain.h"

enum { IMAGE_MOST = 1 << 20, SAMPLES_MOST = 1 << 10, ROOM = 1 << 13 };

typedef struct {
    fc_svm_estimate estimate;
    int32_t status;           /* FC_DONE, or the reason why there is no prediction */
    uint32_t instructions;
} record;

static uint64_t bytes[IMAGE_MOST / 8];
static double volts[SAMPLES_MOST];
static float room[ROOM];
static fc_image image;

int main(int argc, char **argv)
{
    uint32_t n;
    int32_t sizes[2];
    if (!machine_begin(argc, argv) || machine_read(&n, sizeof n) != sizeof n || n > sizeof bytes
        || machine_read(bytes, n) != n
        || fc_image_read((const uint8_t *)bytes, n, &image) != NULL
        || fc_svm_room(image.model.svm) > ROOM)
        return 2;
    while (machine_read(sizes, sizeof sizes) == sizeof sizes) {
        const fc_past past = {volts, SAMPLES_MOST, 1, 0, sizes[0]};
        record r;
        memset(&r, 0, sizeof r);
        if (sizes[0] > SAMPLES_MOST || machine_read(volts, sizeof *volts * (size_t)sizes[0]) == 0)
            return 3;
        const uint32_t before = machine_clock();
        r.status = fc_svm_predict(image.model.svm, &past, 0, sizes[1], room, &r.estimate);
        r.instructions = machine_since(before);
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
