#include "beamform.h"

#include <math.h>

#define LOADING 0.05f
/* As accurate as the core's eigenvector. */
#define TOLERANCE 4e-6f
#define STEP_LIMIT 100

static cfloat r[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static cfloat factor[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static cfloat w[MAX_SUBAPERTURE];
static cfloat e[MAX_SUBAPERTURE];
static cfloat next[MAX_SUBAPERTURE];

/* sum += a b */
static inline void add_product(cfloat *sum, cfloat a, cfloat b) {
    sum->re += a.re * b.re; sum->re -= a.im * b.im;
    sum->im += a.re * b.im; sum->im += a.im * b.re;
}

/* sum += a b* */
static inline void add_product_conj(cfloat *sum, cfloat a, cfloat b) {
    sum->re += a.re * b.re; sum->re += a.im * b.im;
    sum->im += a.im * b.re; sum->im -= a.re * b.im;
}

cfloat das(const cfloat *x, int m) {
    cfloat sum = {0, 0};
    for (int i = 0; i < m; i++) {
        sum.re += x[i].re;
        sum.im += x[i].im;
    }
    return (cfloat){sum.re / m, sum.im / m};
}

/* Eq. 2 for K = 0, the lower triangle; Eq. 3; diagonal loading; the upper triangle. */
static void covariance(const cfloat *x, int m, int l) {
    int subapertures = m - l + 1;
    for (int i = 0; i < l; i++) {
        for (int j = 0; j <= i; j++) {
            cfloat sum = {0, 0};
            for (int p = 0; p < subapertures; p++)
                add_product_conj(&sum, x[p + i], x[p + j]);
            r[i][j].re = sum.re / subapertures;
            r[i][j].im = sum.im / subapertures;
        }
    }
    for (int i = 0; i < l; i++) {
        for (int j = 0; j <= i && i + j < l; j++) {
            cfloat a = r[i][j], b = r[l - 1 - j][l - 1 - i];
            cfloat mean = {0.5f * (a.re + b.re), 0.5f * (a.im + b.im)};
            r[i][j] = mean;
            r[l - 1 - j][l - 1 - i] = mean;
        }
    }
    float trace = 0;
    for (int i = 0; i < l; i++)
        trace += r[i][i].re;
    for (int i = 0; i < l; i++)
        r[i][i].re += LOADING / l * trace;
    for (int i = 0; i < l; i++)
        for (int j = 0; j < i; j++)
            r[j][i] = (cfloat){r[i][j].re, -r[i][j].im};
}

/* R = G G^H, G in the lower triangle of `factor`. */
static void cholesky(int l) {
    for (int i = 0; i < l; i++) {
        for (int j = 0; j < i; j++) {
            cfloat sum = {0, 0};
            for (int k = 0; k < j; k++)
                add_product_conj(&sum, factor[i][k], factor[j][k]);
            factor[i][j].re = (r[i][j].re - sum.re) / factor[j][j].re;
            factor[i][j].im = (r[i][j].im - sum.im) / factor[j][j].re;
        }
        float sum = 0;
        for (int k = 0; k < i; k++)
            sum += factor[i][k].re * factor[i][k].re + factor[i][k].im * factor[i][k].im;
        factor[i][i] = (cfloat){sqrtf(r[i][i].re - sum), 0};
    }
}

/* Eq. 1: w = R^-1 a / (a^H R^-1 a), a = 1. */
static void weights(int l) {
    cholesky(l);
    for (int i = 0; i < l; i++) {
        cfloat sum = {0, 0};
        for (int k = 0; k < i; k++)
            add_product(&sum, factor[i][k], w[k]);
        w[i].re = (1 - sum.re) / factor[i][i].re;
        w[i].im = -sum.im / factor[i][i].re;
    }
    for (int i = l - 1; i >= 0; i--) {
        cfloat sum = {0, 0};
        for (int k = i + 1; k < l; k++)
            add_product_conj(&sum, w[k], factor[k][i]);
        w[i].re = (w[i].re - sum.re) / factor[i][i].re;
        w[i].im = (w[i].im - sum.im) / factor[i][i].re;
    }
    float power = 0;
    for (int i = 0; i < l; i++)
        power += w[i].re;
    for (int i = 0; i < l; i++) {
        w[i].re /= power;
        w[i].im /= power;
    }
}

/* Eq. 4: the weights applied to the mean of the subapertures. */
static cfloat apply(const cfloat *x, int m, int l) {
    int subapertures = m - l + 1;
    cfloat z = {0, 0};
    for (int i = 0; i < l; i++) {
        cfloat sum = {0, 0};
        for (int p = 0; p < subapertures; p++) {
            sum.re += x[p + i].re;
            sum.im += x[p + i].im;
        }
        add_product_conj(&z, sum, w[i]);
    }
    return (cfloat){z.re / subapertures, z.im / subapertures};
}

/* The eigenvector of R's largest eigenvalue, by power iteration, from the core's start vector. */
static void power_iteration(int l) {
    float fraction = 0, length = 0;
    for (int i = 0; i < l; i++) {
        fraction += 0.618034f;
        if (fraction >= 1)
            fraction -= 1;
        e[i] = (cfloat){0.5f + fraction, 0};
        length += e[i].re * e[i].re;
    }
    length = sqrtf(length);
    for (int i = 0; i < l; i++)
        e[i].re /= length;
    for (int step = 0; step < STEP_LIMIT; step++) {
        float power = 0, change = 0;
        for (int i = 0; i < l; i++) {
            cfloat sum = {0, 0};
            for (int j = 0; j < l; j++)
                add_product(&sum, r[i][j], e[j]);
            next[i] = sum;
            power += sum.re * sum.re + sum.im * sum.im;
        }
        float scale = 1 / sqrtf(power);
        for (int i = 0; i < l; i++) {
            cfloat v = {next[i].re * scale, next[i].im * scale};
            float re = v.re - e[i].re, im = v.im - e[i].im;
            change += re * re + im * im;
            e[i] = v;
        }
        if (change <= TOLERANCE * TOLERANCE)
            break;
    }
}

cfloat mv(const cfloat *x, int m, int l) {
    covariance(x, m, l);
    weights(l);
    return apply(x, m, l);
}

/* Eq. 7 with the first eigenvector: w = e e^H w. */
cfloat esmv_rank1(const cfloat *x, int m, int l) {
    covariance(x, m, l);
    weights(l);
    power_iteration(l);
    cfloat share = {0, 0};
    for (int i = 0; i < l; i++)
        add_product_conj(&share, w[i], e[i]);
    for (int i = 0; i < l; i++) {
        w[i] = (cfloat){0, 0};
        add_product(&w[i], e[i], share);
    }
    return apply(x, m, l);
}
