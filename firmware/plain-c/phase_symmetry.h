/* Phase symmetry as a C programmer would write it from the paper's Eq. 9 and 10, with the Fourier
   transform of CMSIS-DSP and whole-image tables and buffers. */

#ifndef PHASE_SYMMETRY_H
#define PHASE_SYMMETRY_H

#define MAX_SIDE 128
#define SCALES 3
#define ORIENTATIONS 6

/* Makes the tables for images of side x side pixels, scales 1/8, 1/16 and 1/32. */
void make_filters(int side);
void phase_symmetry(const float *image, int side, float threshold, float *symmetry);
/* What tables and buffers take for such an image. */
int phase_symmetry_bytes(int side);

#endif
