/* The work of firmware/src/bin/count in plain C: the same input, the same lines printed. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "beamform.h"
#ifdef CMSIS_DSP
#include "phase_symmetry.h"
#endif

#define SAMPLES 32
#define MAX_ELEMENTS 64
#define PRINTED 61

extern uint32_t stack_bottom[], stack_top[];

int main(void);

/* QEMU has zeroed RAM and loaded .data; what is left is to switch on the FPU. */
static void reset(void) {
    *(volatile uint32_t *)0xE000ED88 |= 0xF << 20;
    __asm volatile("dsb\n isb");
    main();
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {stack_top, reset};

/* newlib's: standard output to the host by semihosting. */
void initialise_monitor_handles(void);

/* SysTick: 40 instructions a tick; see src/bin/count/counter.rs. */
#define SYST_CSR (*(volatile uint32_t *)0xE000E010)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018)
#define PAINT 0xCCCCCCCC

static uint32_t begin;
static uint32_t *painted;

static inline __attribute__((always_inline)) void start_count(void) {
    __asm volatile("mov %0, sp" : "=r"(painted));
    for (uint32_t *p = stack_bottom; p < painted; p++)
        *(volatile uint32_t *)p = PAINT;
    begin = SYST_CVR;
}

static void end_count(const char *name, int size, int outputs, int bytes) {
    uint32_t instructions = ((begin - SYST_CVR) & 0xFFFFFF) * 40;
    const uint32_t *p = stack_bottom;
    while (*(const volatile uint32_t *)p == PAINT)
        p++;
    printf("count %s %d %lu %d %d %d\n", name, size, (unsigned long)instructions, outputs, bytes,
          (int)((painted - p) * sizeof *p));
}

static cfloat x[SAMPLES * MAX_ELEMENTS];
static cfloat z[SAMPLES];

static uint32_t state;

static float noise(void) {
    state = state * 1664525 + 1013904223;
    return (float)(state >> 8) / 16777216 - 0.5f;
}

static void snapshots(int elements) {
    static const cfloat quarters[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    state = 1;
    for (int n = 0; n < SAMPLES; n++) {
        for (int m = 0; m < elements; m++) {
            cfloat ahead = quarters[n % 4], side = quarters[(n + m) % 4];
            x[n * elements + m].re = 4 * (ahead.re + 0.3125f * side.re) + noise();
            x[n * elements + m].im = 4 * (ahead.im + 0.3125f * side.im) + noise();
        }
    }
}

static __attribute__((noinline)) void das_line(int m) {
    for (int n = 0; n < SAMPLES; n++)
        z[n] = das(x + n * m, m);
}

static __attribute__((noinline)) void mv_line(int m) {
    for (int n = 0; n < SAMPLES; n++)
        z[n] = mv(x + n * m, m);
}

static __attribute__((noinline)) void esmv_rank1_line(int m) {
    for (int n = 0; n < SAMPLES; n++)
        z[n] = esmv_rank1(x + n * m, m);
}

static __attribute__((noinline)) void esmv_beta_line(int m) {
    for (int n = 0; n < SAMPLES; n++)
        z[n] = esmv_beta(x + n * m, m, 0.01f);
}

static void beamform(const char *name, void (*line)(int), int matrices, int vectors) {
    for (int m = 16; m <= MAX_ELEMENTS; m *= 2) {
        int l = m / 2;
        snapshots(m);
        start_count();
        line(m);
        end_count(name, m, SAMPLES, (matrices * l * l + vectors * l) * (int)sizeof(cfloat));
        for (int n = 0; n < SAMPLES; n++)
            printf("value %s %d %d %.9e %.9e\n", name, m, n, z[n].re, z[n].im);
    }
}

#ifdef CMSIS_DSP
static float image[MAX_SIDE * MAX_SIDE];
static float symmetry[MAX_SIDE * MAX_SIDE];

static int ridge(int at, int top) {
    switch (at < top ? top - at : at - top) {
    case 0:
        return 90;
    case 1:
        return 70;
    case 2:
        return 25;
    default:
        return 0;
    }
}

static void filter(int side) {
    for (int n = 0; n < side * side; n++) {
        int row = n / side, column = n % side;
        int speckle = (uint32_t)n * 2654435761u >> 26;
        image[n] = 10 + speckle + ridge(row, side / 2 + column / 5) + ridge(column, side / 4 + row / 2);
    }
    make_filters(side);
    start_count();
    phase_symmetry(image, side, 3, symmetry);
    end_count("phase-symmetry", side, side * side, phase_symmetry_bytes(side));
    for (int n = 0; n < side * side; n += PRINTED)
        printf("value phase-symmetry %d %d %.9e 0\n", side, n, symmetry[n]);
}
#endif

int main(void) {
    initialise_monitor_handles();
    SYST_RVR = 0xFFFFFF;
    SYST_CVR = 0;
    SYST_CSR = 5;
    beamform("das", das_line, 0, 0);
    beamform("mv", mv_line, 2, 3);
    beamform("esmv-rank1", esmv_rank1_line, 2, 4);
    beamform("esmv-beta", esmv_beta_line, 2, 5);
#ifdef CMSIS_DSP
    filter(64);
    filter(128);
#endif
    exit(0);
}
