/* DAS, MV and ESMV by the core's algorithms: covariance by lag sums, its real form, a real Cholesky factorisation. */

#ifndef BEAMFORM_H
#define BEAMFORM_H

/* float _Complex would do, but its product checks for NaN on every multiplication. */
typedef struct {
    float re, im;
} cfloat;

#define MAX_SUBAPERTURE 32

/* x: m delayed analytic samples, 16, 32 or 64; subapertures have m/2. */
cfloat das(const cfloat *restrict x, int m);
cfloat mv(const cfloat *restrict x, int m);
cfloat esmv_rank1(const cfloat *restrict x, int m);
cfloat esmv_beta(const cfloat *restrict x, int m, float beta);

#endif
