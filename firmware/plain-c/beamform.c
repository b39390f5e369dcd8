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
static cfloat z[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static float d[MAX_SUBAPERTURE];
static float off[MAX_SUBAPERTURE];

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

/* R = Z T Z^H by Householder reflections from the last row on, T real and tridiagonal with diagonal `d`
   and off-diagonal `off`; R is destroyed. */
static void tridiagonal(int l) {
    cfloat *v = e, *q = next;
    for (int i = 0; i < l; i++)
        for (int j = 0; j < l; j++)
            z[i][j] = (cfloat){i == j, 0};
    for (int k = l - 1; k >= 1; k--) {
        float tail = 0;
        for (int i = 0; i < k; i++) {
            v[i] = r[i][k];
            if (i < k - 1)
                tail += v[i].re * v[i].re + v[i].im * v[i].im;
        }
        d[k] = r[k][k].re;
        w[k] = v[k - 1];
        if (tail == 0)
            continue;
        cfloat alpha = v[k - 1];
        float length = sqrtf(alpha.re * alpha.re + alpha.im * alpha.im);
        float norm = sqrtf(length * length + tail);
        cfloat phase = length > 0 ? (cfloat){alpha.re / length, alpha.im / length} : (cfloat){1, 0};
        v[k - 1].re += phase.re * norm;
        v[k - 1].im += phase.im * norm;
        w[k] = (cfloat){-phase.re * norm, -phase.im * norm};
        float tau = 2 / (tail + (length + norm) * (length + norm));
        float half = 0;
        for (int i = 0; i < k; i++) {
            cfloat sum = {0, 0};
            for (int j = 0; j < k; j++)
                add_product(&sum, r[i][j], v[j]);
            q[i] = (cfloat){tau * sum.re, tau * sum.im};
            half += v[i].re * q[i].re + v[i].im * q[i].im;
        }
        half *= tau / 2;
        for (int i = 0; i < k; i++) {
            q[i].re -= half * v[i].re;
            q[i].im -= half * v[i].im;
        }
        for (int i = 0; i < k; i++) {
            for (int j = 0; j <= i; j++) {
                cfloat sum = {0, 0};
                add_product_conj(&sum, v[i], q[j]);
                add_product_conj(&sum, q[i], v[j]);
                r[i][j].re -= sum.re;
                r[i][j].im -= sum.im;
                r[j][i] = (cfloat){r[i][j].re, -r[i][j].im};
            }
        }
        for (int i = 0; i < l; i++) {
            cfloat sum = {0, 0};
            for (int j = 0; j < k; j++)
                add_product(&sum, z[i][j], v[j]);
            sum.re *= -tau;
            sum.im *= -tau;
            for (int j = 0; j < k; j++)
                add_product_conj(&z[i][j], sum, v[j]);
        }
    }
    d[0] = r[0][0].re;
    /* Phases that make the off-diagonal real. */
    cfloat phase = {1, 0};
    for (int k = 1; k < l; k++) {
        float length = sqrtf(w[k].re * w[k].re + w[k].im * w[k].im);
        if (length > 0) {
            cfloat turned = {0, 0};
            add_product_conj(&turned, phase, (cfloat){w[k].re / length, w[k].im / length});
            phase = turned;
        }
        off[k - 1] = length;
        for (int i = 0; i < l; i++) {
            cfloat turned = {0, 0};
            add_product(&turned, z[i][k], phase);
            z[i][k] = turned;
        }
    }
    off[l - 1] = 0;
}

/* Eigenvalues in `d`, eigenvectors in the columns of `z`: implicit QL (EISPACK's tql2). */
static void ql(int l) {
    for (int first = 0; first < l; first++) {
        for (int step = 0; step < 40; step++) {
            int last = first;
            while (last + 1 < l && fabsf(off[last]) > 5.96e-8f * (fabsf(d[last]) + fabsf(d[last + 1])))
                last++;
            if (last == first)
                break;
            float g = (d[first + 1] - d[first]) / (2 * off[first]);
            float root = sqrtf(g * g + 1);
            g = d[last] - d[first] + off[first] / (g >= 0 ? g + root : g - root);
            float s = 1, c = 1, p = 0;
            int i;
            for (i = last - 1; i >= first; i--) {
                float f = s * off[i], b = c * off[i];
                float length = sqrtf(f * f + g * g);
                off[i + 1] = length;
                if (length == 0) {
                    d[i + 1] -= p;
                    off[last] = 0;
                    break;
                }
                s = f / length;
                c = g / length;
                g = d[i + 1] - p;
                float t = (d[i] - g) * s + 2 * c * b;
                p = s * t;
                d[i + 1] = g + p;
                g = c * t - b;
                for (int k = 0; k < l; k++) {
                    cfloat left = z[k][i], right = z[k][i + 1];
                    z[k][i + 1] = (cfloat){s * left.re + c * right.re, s * left.im + c * right.im};
                    z[k][i] = (cfloat){c * left.re - s * right.re, c * left.im - s * right.im};
                }
            }
            if (i >= first)
                continue;
            d[first] -= p;
            off[first] = g;
            off[last] = 0;
        }
    }
}

/* Eq. 5 to 8: the eigenvectors of the largest eigenvalues that make up beta of the metric. */
cfloat esmv_beta(const cfloat *x, int m, int l, float beta) {
    covariance(x, m, l);
    tridiagonal(l);
    ql(l);
    int order[MAX_SUBAPERTURE];
    for (int i = 0; i < l; i++) {
        int place = i;
        for (; place > 0 && d[order[place - 1]] < d[i]; place--)
            order[place] = order[place - 1];
        order[place] = i;
    }
    float total = 0;
    for (int k = 0; k < l; k++) {
        cfloat sum = {0, 0};
        for (int i = 0; i < l; i++) {
            sum.re += z[i][order[k]].re;
            sum.im -= z[i][order[k]].im;
        }
        /* e^H a */
        e[k] = sum;
        total += (sum.re * sum.re + sum.im * sum.im) / d[order[k]];
    }
    for (int i = 0; i < l; i++)
        w[i] = (cfloat){0, 0};
    float reached = 0;
    for (int k = 0; k < l && (k == 0 || reached < beta * total); k++) {
        float value = d[order[k]];
        reached += (e[k].re * e[k].re + e[k].im * e[k].im) / value;
        cfloat share = {e[k].re / (value * total), e[k].im / (value * total)};
        for (int i = 0; i < l; i++)
            add_product(&w[i], z[i][order[k]], share);
    }
    return apply(x, m, l);
}
