/* DAS, MV and ESMV as a C programmer would write them from the paper's equations. */

#ifndef BEAMFORM_H
#define BEAMFORM_H

/* float _Complex would do, but its product checks for NaN on every multiplication. */
typedef struct {
    float re, im;
} cfloat;

#define MAX_SUBAPERTURE 32

/* x: m delayed analytic samples; l: length of a subaperture. */
cfloat das(const cfloat *x, int m);
cfloat mv(const cfloat *x, int m, int l);
cfloat esmv_rank1(const cfloat *x, int m, int l);
cfloat esmv_beta(const cfloat *x, int m, int l, float beta);

#endif
