/* The library's version, and a line by DAS: the mean of each sample's elements. */

#include <stdalign.h>
#include <stdio.h>

#include "bonebeam.h"

static alignas(BONEBEAM_ALIGN) unsigned char memory[1024];

int main(void) {
    const bonebeam_beamform_parameters parameters = {.method = "das"};
    const bonebeam_complex x[2][4] = {{{1, 0}, {2, 0}, {3, 0}, {6, 0}}, {{0, 4}, {0, 4}, {0, 4}, {0, 8}}};
    bonebeam_complex z[2];
    bonebeam_beamformer *beamformer;
    bonebeam_status status = bonebeam_beamformer_new(memory, sizeof memory, &parameters, 4, &beamformer);
    if (status == BONEBEAM_STATUS_OK) {
        const bonebeam_range active[2] = {{0, 4}, {0, 4}};
        status = bonebeam_beamformer_line(beamformer, x[0], 2, 4, active, NULL, z);
    }
    if (status != BONEBEAM_STATUS_OK) {
        printf("%s\n", bonebeam_status_text(status));
        return 1;
    }
    printf("bonebeam %s, header %d.%d.%d: %g%+gi %g%+gi\n", bonebeam_version(), BONEBEAM_VERSION_MAJOR,
           BONEBEAM_VERSION_MINOR, BONEBEAM_VERSION_PATCH, z[0].re, z[0].im, z[1].re, z[1].im);
    return 0;
}
