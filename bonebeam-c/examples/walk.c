/* A random walk over the library's calls.
 *
 *     walk SECONDS [SEED]
 *
 * Each array and each object ends at a page that nothing may touch. Most numbers are usual ones, some of no scanner. An
 * accepted call must give finite numbers, grey levels of 0 to 255, a map of 0 to below 1, and the same bits for a whole
 * line and for its parts; a refused one changes no output. Before it, each number of a structure has its bounds. The
 * compilers' sanitizers watch this program and the library; for them nothing lies before an array either. */

#define _DEFAULT_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(place, bytes)
#define ASAN_UNPOISON_MEMORY_REGION(place, bytes)
#endif

#include "bonebeam.h"

static uint64_t state, seed;

static uint64_t next(void) {
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static size_t below(size_t count) { return (size_t)(next() % count); }
static int once_in(size_t count) { return below(count) == 0; }
static double share(void) { return (double)(next() >> 11) * 0x1p-53; }

/* A usual number, or once in `wild` one that no scanner has. */
static size_t wild = 60;
static double number(double least, double most) {
    static const double others[] = {0, -0.0, -1, 1e-300, 1e300, -1e300, 5e-324, NAN, INFINITY, 1e9, 1e-9};
    return once_in(wild) ? others[below(sizeof others / sizeof *others)] : least + share() * (most - least);
}
static size_t size(size_t least, size_t most) {
    static const size_t others[] = {0, 1, 2, 1u << 20, SIZE_MAX, SIZE_MAX / 2, SIZE_MAX / 8 + 2};
    return once_in(4 * wild) ? others[below(sizeof others / sizeof *others)] : least + below(most - least + 1);
}

/* Memory that ends at a page without access. */
typedef struct {
    char *pages;
    size_t bytes;
} guarded;
static guarded all[64];
static size_t used;

static void *take(size_t bytes) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (bytes + page - 1) / page * page + page;
    char *pages = mmap(NULL, whole + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED || used == sizeof all / sizeof *all) abort();
    mprotect(pages + whole, page, PROT_NONE);
    all[used++] = (guarded){pages, whole + page};
    ASAN_POISON_MEMORY_REGION(pages, whole - bytes);
    /* Objects are aligned to 16 bytes and numbers to 8: their sizes are multiples of it. */
    return pages + whole - bytes;
}
static void drop(size_t before) {
    while (used > before) {
        used--;
        ASAN_UNPOISON_MEMORY_REGION(all[used].pages, all[used].bytes);
        munmap(all[used].pages, all[used].bytes);
    }
}

static void fail(const char *what) {
    printf("walk: %s, seed %llu\n", what, (unsigned long long)seed);
    exit(1);
}
static void within(const float *x, size_t count, double least, double most, const char *what) {
    for (size_t k = 0; k < count; k++)
        if (!(x[k] >= least && x[k] <= most)) {
            printf("%.9g at %zu of %zu\n", (double)x[k], k, count);
            fail(what);
        }
}
static void same(const void *a, const void *b, size_t bytes, const char *what) {
    if (memcmp(a, b, bytes) != 0) fail(what);
}

/* Samples of one of several sizes, and a few far from it. */
static float *samples(size_t count) {
    float *x = take(count * sizeof *x);
    const float scale = ldexpf(1, (int)below(120) - 60), far = once_in(3) ? ldexpf(1, (int)below(180) - 90) : scale;
    const int silent = once_in(12);
    for (size_t k = 0; k < count; k++) x[k] = silent ? 0 : (float)(2 * share() - 1) * (once_in(50) ? far : scale);
    if (once_in(40) && count > 0) x[below(count)] = once_in(2) ? NAN : INFINITY;
    return x;
}

enum { LINES = 4 };
static size_t calls, accepted;
static int ok(bonebeam_status status) {
    calls++;
    accepted += status == BONEBEAM_STATUS_OK;
    return status == BONEBEAM_STATUS_OK;
}

static bonebeam_beamform_parameters beamformer(void) {
    static const char *const methods[] = {"das", "mv", "esmv", "esmv-rank1", "esmv-rank", "esmv-beta", "none"};
    static const char *const filters[] = {NULL, "coherence-factor", "generalized-coherence-factor"};
    static const char *const windows[] = {NULL, "hann", "hamming", "tukey"};
    static bonebeam_number numbers[6];
    numbers[0] = (bonebeam_number){"temporal_half_window", (double)below(4)};
    numbers[1] = (bonebeam_number){"diagonal_loading", number(0.001, 0.2)};
    numbers[2] = (bonebeam_number){"subaperture_ratio", number(0.2, 1)};
    numbers[3] = (bonebeam_number){"tukey_taper", once_in(3) ? -0.0 : number(0, 1)};
    numbers[4] = (bonebeam_number){"coherence_cutoff", (double)below(4)};
    numbers[5] = (bonebeam_number){"depth_step", (double)(1 + (once_in(4) ? below(8) : 0))};
    return (bonebeam_beamform_parameters){
        .method = methods[below(7)], .postfilter = filters[below(3)], .apodization = windows[below(4)],
        .argument = once_in(2) ? 1 + (double)below(3) : number(0.01, 0.9), .covariance = (int32_t)below(2),
        .numbers = numbers, .count = below(7)};
}

static bonebeam_scan scan(int iq) {
    const size_t elements = size(2, 24), outputs = size(2, 70);
    return (bonebeam_scan){
        .delay = {.sound_speed = number(1400, 1700), .sampling_rate = iq ? 10e6 : number(18e6, 42e6), .frequency = number(4e6, 6e6),
                  .output_rate = iq ? 10e6 : number(16e6, 20e6), .output_start = number(0, 4e-6), .output_samples = outputs,
                  .elements = elements, .record_samples = size(40, 260), .hilbert_taps = 0, .single_precision = once_in(6),
                  .interpolation = (int32_t)below(3)},
        .aperture = {elements, number(2e-4, 5e-4), number(0.5, 3), size(1, 9)},
        .lines = {number(-3e-3, 0), number(2e-4, 2e-3), LINES},
        .block = size(1, 40)};
}

static bonebeam_wave wave(const bonebeam_scan *scan) {
    bonebeam_wave wave = {.law = (int32_t)below(once_in(9) ? 6 : 4), .angle = number(-0.3, 0.3), .x = number(-5e-3, 5e-3),
                          .z = number(-5e-3, 5e-3), .t0 = number(0, 1e-6)};
    if (scan->delay.elements < 100) {
        double *delays = take(scan->delay.elements * sizeof *delays);
        for (size_t m = 0; m < scan->delay.elements; m++) delays[m] = number(0, 1e-6);
        wave.delays = delays;
    }
    return wave;
}

static int small(const bonebeam_scan *s) {
    return s->delay.elements < 1000 && s->delay.record_samples < 2000 && s->delay.output_samples < 2000;
}

/* RF to aligned samples to lines: whole, and in parts. */
static void stages(void) {
    const bonebeam_scan s = scan(0);
    const bonebeam_delay_parameters *p = &s.delay;
    const size_t bytes = bonebeam_delay_bytes(p);
    if (bytes == 0 || !small(&s)) return;
    bonebeam_delay *delay;
    if (!ok(bonebeam_delay_new(take(bytes), bytes, p, &delay))) return;
    const size_t M = p->elements, N = p->output_samples;
    double *x = take(M * sizeof *x);
    for (size_t m = 0; m < M; m++) x[m] = ((double)m - (double)(M - 1) / 2) * 3e-4;
    const bonebeam_scan_line line = {.wave = wave(&s), .origin = {number(-2e-3, 2e-3), 0, once_in(3) ? number(-0.4, 0.4) : 0},
                                     .element_x = x, .active = {0, M}};
    const float *rf = samples(M * p->record_samples);
    bonebeam_complex *whole = take(N * M * sizeof *whole), *parts = take(N * M * sizeof *parts);
    memset(whole, 7, N * M * sizeof *whole);
    memcpy(parts, whole, N * M * sizeof *whole);
    if (!ok(bonebeam_delay_line(delay, &line, rf, whole))) {
        same(whole, parts, N * M * sizeof *whole, "a refused line is changed");
        return;
    }
    within(&whole[0].re, 2 * N * M, -3.4e38, 3.4e38, "an aligned sample");
    for (size_t first = 0; first < N;) {
        const size_t rest = N - first, count = 1 + below(rest);
        size_t end;
        if (!ok(bonebeam_delay_block(delay, &line, rf, (bonebeam_range){first, count}, parts + first * M))) fail("a block of a line");
        if (!ok(bonebeam_delay_record_end(delay, &line, (bonebeam_range){first, count}, &end)) || end > p->record_samples)
            fail("the end of a record");
        first += count;
    }
    same(whole, parts, N * M * sizeof *whole, "blocks of aligned samples");
    /* A block does not read what comes after the end of its part of the record. */
    const bonebeam_range block = {below(N), 1};
    size_t end;
    if (!ok(bonebeam_delay_record_end(delay, &line, block, &end))) fail("the end of a record");
    float *cut = take(M * p->record_samples * sizeof *cut);
    for (size_t k = 0; k < M * p->record_samples; k++) cut[k] = k % p->record_samples < end ? rf[k] : 1;
    if (ok(bonebeam_delay_block(delay, &line, cut, block, parts))) same(parts, whole + block.first * M, M * sizeof *whole, "what comes later is read");

    const bonebeam_beamform_parameters by = beamformer();
    const size_t own = bonebeam_beamformer_bytes(&by, M);
    bonebeam_beamformer *beams;
    if (own == 0 || !ok(bonebeam_beamformer_new(take(own), own, &by, M, &beams))) return;
    bonebeam_range *active = take(N * sizeof *active);
    double *depths = take(N * sizeof *depths);
    for (size_t n = 0; n < N; n++) depths[n] = (double)n * 4e-5;
    if (!ok(bonebeam_active_elements(&s.aperture, number(0, (double)M), depths, N, active))) return;
    /* With a depth step there are fewer. */
    size_t step = 1, window = 0;
    for (size_t k = 0; k < by.count; k++) {
        if (strcmp(by.numbers[k].name, "depth_step") == 0) step = (size_t)by.numbers[k].value;
        if (strcmp(by.numbers[k].name, "temporal_half_window") == 0) window = (size_t)by.numbers[k].value;
    }
    const size_t outputs = (N + step - 1) / step;
    bonebeam_complex *z = take(outputs * sizeof *z), *of_parts = take(outputs * sizeof *z);
    if (!ok(bonebeam_beamformer_line(beams, whole, N, M, active, NULL, z))) return;
    within(&z[0].re, 2 * outputs, -3.5e38, 3.5e38, "a line");
    float largest = 0;
    for (size_t k = 0; k < N * M; k++) largest = fmaxf(largest, fmaxf(fabsf(whole[k].re), fabsf(whole[k].im)));
    size_t done = 0;
    for (size_t end = 0; end < N;) {
        end += 1 + below(N - end);
        const size_t first = done < window ? 0 : done - window;
        bonebeam_complex *held = take((end - first) * M * sizeof *held);
        memcpy(held, whole + first * M, (end - first) * M * sizeof *held);
        if (!ok(bonebeam_beamformer_partial_line(beams, held, (bonebeam_range){first, end - first}, N, M, largest, active, NULL, &done, of_parts)))
            fail("a part of a line");
        if (used > 50) return;
    }
    if (done != N) fail("the rest of a line");
    same(z, of_parts, outputs * sizeof *z, "parts of a line");
}

/* A frame: lines, image, map, surface. */
static void frame(void) {
    static const double scales[] = {0.03125, 0.015625, 0.0078125};
    const int iq = once_in(2);
    const double surface = once_in(2) ? number(0, 1e-3) : 0;
    bonebeam_frame_parameters p = {
        .scan = scan(iq), .beamformer = beamformer(),
        .image = {once_in(wild) ? size(0, 100) : 64, 64, size(1, 70), scales, 1 + below(3), (float)number(0, 20)},
        .dynamic_range = (float)number(20, 80), .median = once_in(2), .gain_tables = once_in(2),
        .surface_from = surface, .surface_to = surface == 0 ? 0 : number(2e-3, 1), .surface_coherence = once_in(2) ? 0 : number(1e-4, 6e-4)};
    if (once_in(4)) p.scan.gate_from = number(0, 1e-3), p.scan.gate_to = number(1e-3, 3e-3);
    const size_t bytes = iq ? bonebeam_frame_iq_bytes(&p) : bonebeam_frame_bytes(&p);
    bonebeam_refusal why;
    const bonebeam_status checked = iq ? bonebeam_frame_iq_check(&p, &why) : bonebeam_frame_check(&p, &why);
    if ((bytes != 0) != (checked == BONEBEAM_STATUS_OK)) fail("bytes and check of a frame");
    if (bytes == 0 || bytes > 1u << 28 || !small(&p.scan) || p.scan.lines.count != LINES) return;
    bonebeam_frame *own;
    void *memory = take(bytes);
    if (ok((iq ? bonebeam_frame_iq_new : bonebeam_frame_new)(memory, bytes - 16, &p, &own))) fail("a frame in too little memory");
    if (!ok((iq ? bonebeam_frame_iq_new : bonebeam_frame_new)(memory, bytes, &p, &own))) return;
    const size_t M = p.scan.delay.elements, record = M * p.scan.delay.record_samples, count = 1 + below(3);
    bonebeam_complex *z = take(p.scan.delay.output_samples * sizeof *z);
    size_t step = 1;
    for (size_t k = 0; k < p.beamformer.count; k++)
        if (strcmp(p.beamformer.numbers[k].name, "depth_step") == 0) step = (size_t)p.beamformer.numbers[k].value;
    z += p.scan.delay.output_samples - (p.scan.delay.output_samples + step - 1) / step;
    for (size_t k = 0; k < LINES; k++) {
        bonebeam_rf_wave rf[3];
        bonebeam_iq_wave both[3];
        const size_t before = used;
        for (size_t w = 0; w < count; w++) {
            rf[w].wave = both[w].wave = wave(&p.scan);
            rf[w].rf = samples(iq ? 2 * record : record);
            both[w].record = (bonebeam_iq_record){.samples = (const bonebeam_complex *)rf[w].rf, .layout = (int32_t)below(2)};
        }
        if (ok(iq ? bonebeam_frame_iq_line(own, below(LINES), both, count, z) : bonebeam_frame_line(own, below(LINES), rf, count, z)))
            within(&z[0].re, 2 * ((p.scan.delay.output_samples + step - 1) / step), -3.5e38, 3.5e38, "a line of a frame");
        drop(before);
    }
    const float *image, *map;
    if (!ok(bonebeam_frame_image(own, NULL, NULL, &image))) fail("the image of a frame");
    within(image, p.image.rows * p.image.columns, 0, 255, "a grey level of a frame");
    if (!ok(bonebeam_frame_map(own, NULL, NULL, &map))) fail("the map of a frame");
    within(map, p.image.rows * p.image.columns, 0, 0x1.fffffep-1, "a value of a map");
    bonebeam_point *points = take(LINES * sizeof *points);
    if (ok(bonebeam_frame_surface(own, points)))
        for (size_t k = 0; k < LINES; k++) {
            within(&points[k].depth, 1, 0, 10, "a depth");
            within(&points[k].confidence, 1, 0, 1, "a confidence");
        }
}

/* Envelopes to pixels. */
static void pictures(void) {
    const size_t beams = size(2, 12), depths = size(2, 30), rows = size(1, 40), columns = size(1, 40);
    if (beams > 1000 || depths > 1000 || rows > 1000 || columns > 1000) return;
    const float *parts = samples(2 * beams * depths);
    float *envelopes = take(beams * depths * sizeof(float)), *levels = take(beams * depths * sizeof(float));
    float *pixels = take(rows * columns * sizeof(float)), *filtered = take(rows * columns * sizeof(float));
    if (!ok(bonebeam_envelope((const bonebeam_complex *)parts, beams * depths, envelopes))) return;
    const float largest = bonebeam_largest(envelopes, beams * depths);
    if (!ok(bonebeam_log_compression((int32_t)below(2), envelopes, beams * depths, largest, (float)number(1, 90), levels))) return;
    within(levels, beams * depths, 0, 255, "a grey level");
    const bonebeam_axis x = {0, 1, beams}, z = {0, 1, depths};
    const bonebeam_axis row = {number(-1, 2), number(0.05, 1), rows}, column = {number(-1, 2), number(0.05, 1), columns};
    if (!ok(bonebeam_resample(levels, &x, &z, &row, &column, pixels))) return;
    within(pixels, rows * columns, 0, 255, "a pixel");
    if (ok(bonebeam_median(pixels, rows, columns, filtered))) within(filtered, rows * columns, 0, 255, "a filtered pixel");
}

/* A number of a structure, and the magnitudes that the command and files accept. */
typedef struct {
    const char *name;
    double *at;
    float *single;
    double least, most;
} field;

static void put(const field *f, double value) {
    if (f->at) *f->at = value;
    if (f->single) *f->single = (float)value;
}

/* Values outside are refused: a frame by the field's name. */
static void bounds(const field *fields, size_t count, bonebeam_status (*judge)(bonebeam_refusal *)) {
    for (size_t k = 0; k < count; k++) {
        const field *f = &fields[k];
        const double before = f->at ? *f->at : (double)*f->single;
        const double outside[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 1.001 * f->most, -1.001 * f->most,
                                  f->least > 0 ? 0.999 * f->least : -1e300};
        for (size_t n = 0; n < sizeof outside / sizeof *outside; n++) {
            if (isinf(outside[n]) && outside[n] > 0 && strcmp(f->name, "surface_to") == 0) continue;
            if (isnan(outside[n]) && strcmp(f->name, "delays") == 0) continue;
            bonebeam_refusal why = {{0}, 0, {0}};
            put(f, outside[n]);
            const bonebeam_status status = judge(&why);
            if (status != BONEBEAM_STATUS_PARAMETER || (why.name[0] != 0 && !strstr(why.name, f->name))) {
                printf("%s is %g: status %d, %s\n", f->name, outside[n], (int)status, why.name);
                fail("bounds of a field");
            }
        }
        put(f, before);
    }
}

static double scale[] = {0.03125}, element_x[4] = {0, 3e-4, 6e-4, 9e-4}, firing[4];
static bonebeam_element elements[4];
static bonebeam_number numbers[] = {
    {"temporal_half_window", 1}, {"diagonal_loading", 0.01}, {"subaperture_ratio", 0.5}, {"coherence_cutoff", 1},
    {"tukey_taper", 0.5}, {"depth_step", 1}};
static bonebeam_frame_parameters usual = {
    .scan = {.delay = {1540, 20e6, 5e6, 20e6, 1e-6, 100, 4, 300, 0, 0, 0}, .aperture = {4, 3e-4, 1.5, 2},
             .lines = {-3e-4, 2e-4, LINES}, .gate_from = 1e-3, .gate_to = 3e-3, .block = 40},
    .beamformer = {.method = "esmv-beta", .argument = 0.1, .numbers = numbers, .count = 6},
    .image = {64, 64, 64, scale, 1, 10}, .dynamic_range = 60,
    .surface_from = 1e-3, .surface_to = 1, .surface_coherence = 4e-4};
static bonebeam_scan_line line = {.origin = {0, 0, 0.1}, .pitch = 3e-4, .active = {0, 4}};
static int16_t counts[2 * 4 * 300];
static bonebeam_iq_record record = {.counts = counts, .scale = 1};
static bonebeam_iq *iq;

static bonebeam_status of_frame(bonebeam_refusal *why) { return bonebeam_frame_check(&usual, why); }
static bonebeam_status of_line(bonebeam_refusal *why) {
    static bonebeam_complex out[4 * 100];
    (void)why;
    return bonebeam_iq_line(iq, &line, &record, out);
}

static void fields(void) {
    bonebeam_scan *s = &usual.scan;
    const field of_frames[] = {
        {"sound_speed", &s->delay.sound_speed, NULL, 100, 20e3}, {"sampling_rate", &s->delay.sampling_rate, NULL, 1e4, 1e10},
        {"frequency", &s->delay.frequency, NULL, 1e4, 1e10}, {"output_rate", &s->delay.output_rate, NULL, 1e3, 1e10},
        {"output_start", &s->delay.output_start, NULL, 0, 20 / 1540.0}, {"pitch", &s->aperture.pitch, NULL, 1e-6, 1e-2},
        {"f_number", &s->aperture.f_number, NULL, 1e-3, 1e6}, {"lines.first", &s->lines.first, NULL, 0, 10},
        {"lines.step", &s->lines.step, NULL, 1e-6, 1}, {"gate_from", &s->gate_from, NULL, 0, 10},
        {"gate_to", &s->gate_to, NULL, 0, 10}, {"beta", &usual.beamformer.argument, NULL, 0, 1},
        {"temporal_half_window", &numbers[0].value, NULL, 0, 1e9}, {"diagonal_loading", &numbers[1].value, NULL, 0, 1e9},
        {"subaperture_ratio", &numbers[2].value, NULL, 0, 1}, {"coherence_cutoff", &numbers[3].value, NULL, 0, 1e9},
        {"tukey_taper", &numbers[4].value, NULL, 0, 1}, {"depth_step", &numbers[5].value, NULL, 1, 1e9},
        {"scale", &scale[0], NULL, 1 / 1024.0, 0.5}, {"threshold", NULL, &usual.image.threshold, 0, 1e12},
        {"dynamic_range", NULL, &usual.dynamic_range, 0.1, 1000}, {"surface_from", &usual.surface_from, NULL, 0, 10},
        {"surface_to", &usual.surface_to, NULL, 0, 10}, {"surface_coherence", &usual.surface_coherence, NULL, 0, 10}};
    const field of_lines[] = {
        {"t0", &line.wave.t0, NULL, 0, 20 / 1540.0}, {"origin.x", &line.origin.x, NULL, 0, 10},
        {"origin.z", &line.origin.z, NULL, 0, 10}, {"origin.angle", &line.origin.angle, NULL, 0, 1.5708},
        {"scale", NULL, &record.scale, 0, 1e29 / 32768}};
    const field of_source[] = {{"x", &line.wave.x, NULL, 0, 10}, {"z", &line.wave.z, NULL, 0, 10}};
    const field of_plane = {"angle", &line.wave.angle, NULL, 0, 1.5708}, of_delays = {"delays", &firing[2], NULL, 0, 1e-3};
    const field of_elements[] = {{"pitch", &line.pitch, NULL, 1e-6, 1e-2}, {"x", &elements[1].x, NULL, 0, 10},
                                 {"z", &elements[2].z, NULL, 0, 10}, {"angle", &elements[3].angle, NULL, 0, 1.5708}};
    const field of_x[] = {{"element_x", &element_x[1], NULL, 0, 10}, {"element_x", &element_x[3], NULL, 0, 0.03}};
    bonebeam_refusal why;
    if (of_frame(&why) != BONEBEAM_STATUS_OK) fail(why.name);
    bounds(of_frames, sizeof of_frames / sizeof *of_frames, of_frame);
    bonebeam_delay_parameters p = s->delay;
    p.interpolation = BONEBEAM_INTERPOLATION_LINEAR;
    const size_t bytes = bonebeam_iq_bytes(&p);
    if (bonebeam_iq_new(take(bytes), bytes, &p, &iq) != BONEBEAM_STATUS_OK) fail("a stage of usual numbers");
    line.element_x = element_x;
    if (of_line(&why) != BONEBEAM_STATUS_OK) fail("a line of usual numbers");
    bounds(of_lines, sizeof of_lines / sizeof *of_lines, of_line);
    bounds(of_x, sizeof of_x / sizeof *of_x, of_line);
    line.wave.law = BONEBEAM_LAW_PLANE;
    bounds(&of_plane, 1, of_line);
    line.wave.delays = firing;
    line.wave.law = BONEBEAM_LAW_DELAYS;
    bounds(&of_delays, 1, of_line);
    line.wave.law = BONEBEAM_LAW_ELEMENT;
    bounds(of_source, 2, of_line);
    line.wave.law = BONEBEAM_LAW_SOURCE;
    bounds(of_source, 2, of_line);
    line.element_x = NULL;
    line.elements = elements;
    if (bonebeam_convex_array(3e-4, 0.05, elements, 4) != BONEBEAM_STATUS_OK || of_line(&why) != BONEBEAM_STATUS_OK) fail("a curved array");
    bounds(of_elements, sizeof of_elements / sizeof *of_elements, of_line);
    const double outside[] = {NAN, INFINITY, 1e300, 0, 11};
    for (size_t k = 0; k < sizeof outside / sizeof *outside; k++) {
        float level = 0, envelope = 1;
        bonebeam_element origin;
        if (bonebeam_convex_array(outside[k], 0.05, elements, 4) == BONEBEAM_STATUS_OK ||
            bonebeam_convex_array(3e-4, outside[k], elements, 4) == BONEBEAM_STATUS_OK ||
            bonebeam_normal(elements, 4, outside[k], 1, &origin) == BONEBEAM_STATUS_OK ||
            bonebeam_log_compression(0, &envelope, 1, 1, (float)outside[k] * 100, &level) == BONEBEAM_STATUS_OK)
            fail("bounds of an argument");
    }
    drop(0);
}

int main(int count, char **words) {
    const double seconds = count > 1 ? atof(words[1]) : 10;
    const clock_t begin = clock();
    size_t rounds = 0;
    fields();
    while ((double)(clock() - begin) / CLOCKS_PER_SEC < seconds) {
        state = seed = (count > 2 ? strtoull(words[2], NULL, 10) : 1) + rounds++;
        void (*const walks[])(void) = {stages, stages, frame, pictures};
        wild = once_in(3) ? 12 : 200;
        walks[below(4)]();
        drop(0);
    }
    printf("%zu rounds, %zu calls, %zu of them accepted, %.0f s\n", rounds, calls, accepted, seconds);
}
