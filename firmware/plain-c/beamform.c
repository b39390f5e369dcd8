#include "beamform.h"

#include <math.h>

/* Sizes are constants in each copy, so that loops and addresses are the compiler's. */
#define INLINE static inline __attribute__((always_inline))
#define FOR_SIZES(CALL, m) \
    switch (m) { \
    case 16: return CALL(16, 8); \
    case 32: return CALL(32, 16); \
    default: return CALL(64, 32); \
    }

#define LOADING 0.05f
/* As accurate as the core's eigenvector. */
#define TOLERANCE 4e-6f
#define STEP_LIMIT 100

/* Entries of the covariance, a row a lag: `lags[k][i]` is R[i + k][i], times 2 P. */
static cfloat lags[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static cfloat products[2 * MAX_SUBAPERTURE];
/* The covariance in the basis in which it is real: l/2 vectors e_i + e_(l-1-i), then l/2 vectors
   j (e_i - e_(l-1-i)), each of length sqrt(2). `weight` holds coefficients of the same basis. */
static float t[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static float factor[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static float z[MAX_SUBAPERTURE][MAX_SUBAPERTURE];
static float weight[MAX_SUBAPERTURE], e[MAX_SUBAPERTURE], next[MAX_SUBAPERTURE];
static float d[MAX_SUBAPERTURE], off[MAX_SUBAPERTURE];

cfloat das(const cfloat *restrict x, int m) {
    cfloat sum = {0, 0};
    for (int i = 0; i < m; i++) {
        sum.re += x[i].re;
        sum.im += x[i].im;
    }
    return (cfloat){sum.re / m, sum.im / m};
}

/* a b* */
INLINE cfloat product(cfloat a, cfloat b) {
    return (cfloat){a.re * b.re + a.im * b.im, a.im * b.re - a.re * b.im};
}

/* Eq. 2 for K = 0 and Eq. 3: entries of a lag are sums of the same products, and each is one more product and one
   fewer than its neighbour. */
INLINE void lag_sums(const cfloat *restrict x, int m, int l) {
    int subapertures = m - l + 1;
    for (int k = 0; k < l; k++) {
        cfloat sum = {0, 0};
        for (int i = 0; i < subapertures; i++) {
            products[i] = product(x[i + k], x[i]);
            sum.re += products[i].re;
            sum.im += products[i].im;
        }
        cfloat *row = lags[k];
        int entries = l - k;
        row[0] = sum;
        for (int i = 1; i < entries; i++) {
            cfloat in = product(x[i + subapertures - 1 + k], x[i + subapertures - 1]);
            products[i + subapertures - 1] = in;
            sum.re += in.re - products[i - 1].re;
            sum.im += in.im - products[i - 1].im;
            row[i] = sum;
        }
        for (int i = 0, j = entries - 1; i <= j; i++, j--) {
            cfloat both = {row[i].re + row[j].re, row[i].im + row[j].im};
            row[i] = row[j] = both;
        }
    }
}

/* The loaded covariance in its real basis, both triangles. l is even. */
INLINE void covariance(const cfloat *restrict x, int m, int l) {
    lag_sums(x, m, l);
    int half = l / 2;
    float scale = 0.5f / (m - l + 1), trace = 0;
    for (int i = 0; i < half; i++) {
        for (int j = 0; j <= i; j++) {
            cfloat a = lags[i - j][j], b = lags[l - 1 - j - i][i];
            float sum = scale * (a.re + b.re), difference = scale * (a.re - b.re);
            float left = scale * (a.im - b.im), right = scale * (-a.im - b.im);
            t[i][j] = t[j][i] = sum;
            t[half + i][half + j] = t[half + j][half + i] = difference;
            t[half + i][j] = t[j][half + i] = left;
            t[half + j][i] = t[i][half + j] = right;
        }
        trace += 2 * scale * lags[0][i].re;
    }
    for (int i = 0; i < l; i++)
        t[i][i] += LOADING / l * trace;
}

/* Eq. 1, w = R^-1 a / (a^H R^-1 a) with a = 1: T = G G^T by a real Cholesky factorisation, whose rows solve G y = c
   at once; then G^T w = y. */
INLINE void weights(int l) {
    int half = l / 2;
    for (int i = 0; i < l; i++) {
        float *restrict row = factor[i];
        int j = 0;
        /* Four columns at a time share the loads of the row. */
        for (; j + 4 <= i; j += 4) {
            const float *restrict a = factor[j], *restrict b = factor[j + 1];
            const float *restrict c = factor[j + 2], *restrict d = factor[j + 3];
            float p = t[i][j], q = t[i][j + 1], r = t[i][j + 2], s = t[i][j + 3];
            for (int k = 0; k < j; k++) {
                float own = row[k];
                p -= own * a[k];
                q -= own * b[k];
                r -= own * c[k];
                s -= own * d[k];
            }
            p *= a[j];
            q = (q - p * b[j]) * b[j + 1];
            r = (r - p * c[j] - q * c[j + 1]) * c[j + 2];
            s = (s - p * d[j] - q * d[j + 1] - r * d[j + 2]) * d[j + 3];
            row[j] = p;
            row[j + 1] = q;
            row[j + 2] = r;
            row[j + 3] = s;
        }
        for (; j < i; j++) {
            const float *restrict above = factor[j];
            float sum = t[i][j];
            for (int k = 0; k < j; k++)
                sum -= row[k] * above[k];
            row[j] = sum * above[j];
        }
        float sum = t[i][i], y = i < half;
        for (int k = 0; k < i; k++) {
            sum -= row[k] * row[k];
            y -= row[k] * weight[k];
        }
        /* The diagonal holds reciprocals. */
        row[i] = 1 / sqrtf(sum);
        weight[i] = y * row[i];
    }
    for (int i = l - 1; i >= 0; i--) {
        const float *restrict row = factor[i];
        float w = weight[i] * row[i];
        weight[i] = w;
        for (int k = 0; k < i; k++)
            weight[k] -= w * row[k];
    }
    float power = 0;
    for (int i = 0; i < half; i++)
        power += weight[i];
    float scale = 0.5f / power;
    for (int i = 0; i < l; i++)
        weight[i] *= scale;
}

/* Eq. 4: the weights applied to the mean of the subapertures. */
INLINE cfloat apply(const cfloat *restrict x, int m, int l) {
    int subapertures = m - l + 1, half = l / 2;
    cfloat mean[MAX_SUBAPERTURE], sum = {0, 0}, out = {0, 0};
    for (int i = 0; i < subapertures; i++) {
        sum.re += x[i].re;
        sum.im += x[i].im;
    }
    mean[0] = sum;
    for (int i = 1; i < l; i++) {
        sum.re += x[i + subapertures - 1].re - x[i - 1].re;
        sum.im += x[i + subapertures - 1].im - x[i - 1].im;
        mean[i] = sum;
    }
    for (int i = 0; i < half; i++) {
        cfloat a = mean[i], b = mean[l - 1 - i];
        out.re += weight[i] * (a.re + b.re) + weight[half + i] * (a.im - b.im);
        out.im += weight[i] * (a.im + b.im) - weight[half + i] * (a.re - b.re);
    }
    return (cfloat){out.re / subapertures, out.im / subapertures};
}

/* The eigenvector of T's largest eigenvalue, by power iteration. */
INLINE void power_iteration(int l) {
    float fraction = 0, length = 0;
    for (int i = 0; i < l; i++) {
        fraction += 0.618034f;
        if (fraction >= 1)
            fraction -= 1;
        e[i] = 0.5f + fraction;
        length += e[i] * e[i];
    }
    length = 1 / sqrtf(length);
    for (int i = 0; i < l; i++)
        e[i] *= length;
    for (int step = 0; step < STEP_LIMIT; step++) {
        float power = 0, change = 0;
        for (int i = 0; i < l; i += 4) {
            float p = 0, q = 0, r = 0, s = 0;
            for (int j = 0; j < l; j++) {
                float v = e[j];
                p += t[i][j] * v;
                q += t[i + 1][j] * v;
                r += t[i + 2][j] * v;
                s += t[i + 3][j] * v;
            }
            next[i] = p;
            next[i + 1] = q;
            next[i + 2] = r;
            next[i + 3] = s;
            power += p * p + q * q + r * r + s * s;
        }
        float scale = 1 / sqrtf(power);
        for (int i = 0; i < l; i++) {
            float v = next[i] * scale, difference = v - e[i];
            change += difference * difference;
            e[i] = v;
        }
        if (change <= TOLERANCE * TOLERANCE)
            break;
    }
}

INLINE cfloat mv_of(const cfloat *restrict x, int m, int l) {
    covariance(x, m, l);
    weights(l);
    return apply(x, m, l);
}

/* Eq. 7 with the first eigenvector: w = e e^H w. */
INLINE cfloat esmv_rank1_of(const cfloat *restrict x, int m, int l) {
    covariance(x, m, l);
    weights(l);
    power_iteration(l);
    float share = 0;
    for (int i = 0; i < l; i++)
        share += e[i] * weight[i];
    for (int i = 0; i < l; i++)
        weight[i] = share * e[i];
    return apply(x, m, l);
}

/* T = Z D Z^T by Householder reflections from the last row on, D tridiagonal with diagonal `d` and off-diagonal `off`;
   of T the lower triangle is read, and destroyed. */
INLINE void tridiagonal(int l) {
    float tau[MAX_SUBAPERTURE], *restrict q = next;
    for (int k = l - 1; k >= 1; k--) {
        float *restrict v = t[k], tail = 0, alpha = v[k - 1];
        for (int i = 0; i < k - 1; i++)
            tail += v[i] * v[i];
        d[k] = v[k];
        off[k - 1] = alpha;
        tau[k] = 0;
        if (tail == 0)
            continue;
        float norm = copysignf(sqrtf(alpha * alpha + tail), alpha), projection = 0;
        v[k - 1] = alpha + norm;
        off[k - 1] = -norm;
        tau[k] = 2 / (tail + v[k - 1] * v[k - 1]);
        for (int i = 0; i < k; i++) {
            const float *restrict row = t[i];
            float sum = row[i] * v[i], own = v[i];
            for (int j = 0; j < i; j++) {
                sum += row[j] * v[j];
                q[j] += row[j] * own;
            }
            q[i] = sum;
        }
        for (int i = 0; i < k; i++) {
            q[i] *= tau[k];
            projection += v[i] * q[i];
        }
        projection *= tau[k] / 2;
        for (int i = 0; i < k; i++)
            q[i] -= projection * v[i];
        for (int i = 0; i < k; i++) {
            float *restrict row = t[i], a = v[i], b = q[i];
            for (int j = 0; j <= i; j++)
                row[j] -= a * q[j] + b * v[j];
        }
    }
    d[0] = t[0][0];
    off[l - 1] = 0;
    /* The product of the reflections, from the smallest on. */
    for (int i = 0; i < l; i++)
        for (int j = 0; j < l; j++)
            z[i][j] = i == j;
    for (int k = 2; k < l; k++) {
        const float *restrict v = t[k];
        float sum[MAX_SUBAPERTURE] = {0};
        for (int i = 0; i < k; i++)
            for (int j = 0; j < k; j++)
                sum[j] += v[i] * z[i][j];
        for (int i = 0; i < k; i++) {
            float scaled = tau[k] * v[i];
            for (int j = 0; j < k; j++)
                z[i][j] -= scaled * sum[j];
        }
    }
}

/* Eigenvalues in `d`, eigenvectors in the columns of `z`: implicit QL (EISPACK's tql2). */
INLINE void ql(int l) {
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
                float turn = (d[i] - g) * s + 2 * c * b;
                p = s * turn;
                d[i + 1] = g + p;
                g = c * turn - b;
                for (int k = 0; k < l; k++) {
                    float left = z[k][i], right = z[k][i + 1];
                    z[k][i + 1] = s * left + c * right;
                    z[k][i] = c * left - s * right;
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
INLINE cfloat esmv_beta_of(const cfloat *restrict x, int m, int l, float beta) {
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
    /* e^H a over sqrt(2), and the metric over 2. */
    float total = 0;
    for (int k = 0; k < l; k++) {
        float sum = 0;
        for (int i = 0; i < l / 2; i++)
            sum += z[i][order[k]];
        e[k] = sum;
        total += sum * sum / d[order[k]];
    }
    for (int i = 0; i < l; i++)
        weight[i] = 0;
    float reached = 0;
    for (int k = 0; k < l && (k == 0 || reached < beta * total); k++) {
        float value = d[order[k]], share = e[k] / (2 * value * total);
        reached += e[k] * e[k] / value;
        for (int i = 0; i < l; i++)
            weight[i] += share * z[i][order[k]];
    }
    return apply(x, m, l);
}

#define MV(m, l) mv_of(x, m, l)
#define RANK1(m, l) esmv_rank1_of(x, m, l)
#define BETA(m, l) esmv_beta_of(x, m, l, beta)

cfloat mv(const cfloat *restrict x, int m) {
    FOR_SIZES(MV, m)
}

cfloat esmv_rank1(const cfloat *restrict x, int m) {
    FOR_SIZES(RANK1, m)
}

cfloat esmv_beta(const cfloat *restrict x, int m, float beta) {
    FOR_SIZES(BETA, m)
}
