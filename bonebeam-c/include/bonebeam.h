/* bonebeam for C. Made by cbindgen from bonebeam-c/src: do not edit.
 *
 * MIT OR Apache-2.0
 *
 * Objects. An object lives in memory of the caller's. For an object X:
 *
 * - bonebeam_X_bytes returns the bytes that a configuration needs. 0: the configuration is null or not valid.
 * - bonebeam_X_new checks the configuration, places the object in `memory`, which has so many `bytes` and is aligned to
 *   BONEBEAM_ALIGN, and writes the handle. Memory that is null or not aligned gives BONEBEAM_STATUS_POINTER, memory
 *   that is too small BONEBEAM_STATUS_STORAGE. What a pointer in the configuration leads to is copied.
 * - The other functions take the handle. There is nothing to free: the object ends when the memory is used again.
 *
 * The memory may be static, as on a microcontroller without a heap:
 *
 *     static alignas(BONEBEAM_ALIGN) unsigned char memory[6912];
 *     status = bonebeam_beamformer_new(memory, sizeof memory, &parameters, 32, &beamformer);
 *
 * bonebeam_X_bytes on a workstation gives the number to write there: processors of 32 bits need as much or less.
 *
 * Calls. A status other than 0 leaves the outputs as they were, unless a function says otherwise. A pointer that is
 * null or not aligned is refused, and so is an output that overlaps an array that the same call reads:
 * BONEBEAM_STATUS_POINTER. Integers that name an enumerator take no other value: BONEBEAM_STATUS_PARAMETER.
 *
 * The caller promises the rest: a pointer leads to as many values as its function says, no array overlaps an object's
 * memory, and one thread at a time uses an object. */

#ifndef BONEBEAM_H
#define BONEBEAM_H

#include <stddef.h>
#include <stdint.h>

// The most transmits that one line is compounded of.
#define BONEBEAM_IQ_WAVES 16

// Alignment, bytes, of the memory of every object.
#define BONEBEAM_ALIGN 64

// The result of a call.
enum bonebeam_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done.
  BONEBEAM_STATUS_OK = 0,
  // A parameter is outside its range.
  BONEBEAM_STATUS_PARAMETER = 1,
  // An array does not have the length that the shapes ask for.
  BONEBEAM_STATUS_LENGTH = 2,
  // A size exceeds a capacity.
  BONEBEAM_STATUS_CAPACITY = 3,
  // An input sample is NaN or infinite.
  BONEBEAM_STATUS_NON_FINITE = 4,
  // External memory could not be read or written.
  BONEBEAM_STATUS_MEMORY = 5,
  // A pointer is null or not aligned, or an output overlaps an input.
  BONEBEAM_STATUS_POINTER = 6,
  // The object's memory is smaller than its `_bytes` function says.
  BONEBEAM_STATUS_STORAGE = 7,
  // An error that this version has no number for.
  BONEBEAM_STATUS_OTHER = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_status bonebeam_status;
#else
typedef int32_t bonebeam_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The covariance that adaptive methods use.
typedef enum {
  // Forward-backward averaging: real arithmetic, the faster.
  BONEBEAM_COVARIANCE_FORWARD_BACKWARD = 0,
  // Forward averaging, unless the library was built without its feature `forward`.
  BONEBEAM_COVARIANCE_FORWARD = 1,
} bonebeam_covariance;

// The transmitted waves.
typedef enum {
  // A beam focused along the line.
  BONEBEAM_LAW_FOCUSED = 0,
  // A plane wave at `angle`.
  BONEBEAM_LAW_PLANE = 1,
  // A single element at `x`, `z`.
  BONEBEAM_LAW_ELEMENT = 2,
  // A virtual source at `x`, `z`. `z` ≤ 0: diverging. `z` > 0: converging on it, then diverging.
  BONEBEAM_LAW_SOURCE = 3,
  // The first arrival from elements that fire at `delays`.
  BONEBEAM_LAW_DELAYS = 4,
} bonebeam_law;

// The order of the samples of I/Q.
typedef enum {
  // `[element][sample]`, as in recordings.
  BONEBEAM_LAYOUT_PLANAR = 0,
  // `[sample][element]`, as from a front end.
  BONEBEAM_LAYOUT_INTERLEAVED = 1,
} bonebeam_layout;

// The computation of decibels.
typedef enum {
  // libm's logarithm.
  BONEBEAM_LOGARITHM_EXACT = 0,
  // A polynomial, a third of the instructions. `Logarithm::Polynomial` in the core's documentation has the error.
  BONEBEAM_LOGARITHM_POLYNOMIAL = 1,
} bonebeam_logarithm;

// Interpolation of I/Q. `IqInterpolation::for_band` in the core's documentation says which is enough.
typedef enum {
  // Linear.
  BONEBEAM_INTERPOLATION_LINEAR = 0,
  // Cubic, through four samples.
  BONEBEAM_INTERPOLATION_CUBIC = 1,
  // A windowed sinc of 12 taps.
  BONEBEAM_INTERPOLATION_SINC = 2,
  // Linear in fixed point, of counts only. `IqInterpolation::LinearFixed` in the core's documentation has the limits.
  BONEBEAM_INTERPOLATION_LINEAR_FIXED = 3,
} bonebeam_interpolation;

// A beamformer of aligned samples.
typedef struct bonebeam_beamformer bonebeam_beamformer;

// A delay stage for RF.
typedef struct bonebeam_delay bonebeam_delay;

// The lines of a scan of I/Q: delay stage, apertures and beamformer.
typedef struct bonebeam_iq_lines bonebeam_iq_lines;

// A delay stage for I/Q.
typedef struct bonebeam_iq bonebeam_iq;

// Phase symmetry of images of one size.
typedef struct bonebeam_phase_symmetry bonebeam_phase_symmetry;

// An aperture that grows with depth.
typedef struct {
  // Elements of the array.
  size_t elements;
  // The distance of neighbouring elements, m.
  double pitch;
  // Depth over width.
  double f_number;
  // The fewest active elements.
  size_t min_elements;
} bonebeam_aperture;

// Consecutive elements or samples.
typedef struct {
  // The first one.
  size_t first;
  // Their number.
  size_t count;
} bonebeam_range;

// A parameter by its name in the tables of docs/numerics.md: "temporal_half_window", "diagonal_loading",
// "subaperture_ratio" and others. Of several with one name the last counts.
typedef struct {
  // The name.
  const char *name;
  // The value.
  double value;
} bonebeam_number;

// The parameters of a beamformer.
typedef struct {
  // The key of a method: "das", "mv", "esmv-rank1" and others in the tables of docs/numerics.md.
  const char *method;
  // The key of a postfilter in the same tables, for instance "coherence-factor"; null for none.
  const char *postfilter;
  // The key of an apodization in the same tables, for instance "hann"; null for none.
  const char *apodization;
  // The method's argument, if it has one in the tables: β, a rank, a number of steps.
  double argument;
  // One of `bonebeam_covariance`.
  int32_t covariance;
  // The parameters that do not have their defaults, `count` of them; may be null for none.
  const bonebeam_number *numbers;
  // How many `numbers` there are.
  size_t count;
} bonebeam_beamform_parameters;

// A complex number.
typedef struct {
  // The real part.
  float re;
  // The imaginary part.
  float im;
} bonebeam_complex;

// The parameters of a delay stage, of RF or of I/Q. SI units.
typedef struct {
  // Speed of sound, m/s.
  double sound_speed;
  // Sampling rate of the record, Hz; of I/Q complex samples a second.
  double sampling_rate;
  // RF: centre frequency of the pulse, Hz. I/Q: frequency of the demodulation, Hz.
  double frequency;
  // Output rate, Hz; of RF at least a sixteenth of the sampling rate.
  double output_rate;
  // Two-way time of output sample 0, s.
  double output_start;
  // Output samples of a line.
  size_t output_samples;
  // Elements of the array.
  size_t elements;
  // Samples of each element's record.
  size_t record_samples;
  // RF: non-zero taps on one side of the Hilbert transformer, for instance 8.
  size_t hilbert_taps;
  // RF: not 0 computes the filters in single precision, for processors that compute doubles in software. It
  // takes a fiftieth of the instructions, and lines have other bits.
  int32_t single_precision;
  // I/Q: one of `bonebeam_interpolation`.
  int32_t interpolation;
} bonebeam_delay_parameters;

// One transmit.
typedef struct {
  // One of `bonebeam_law`.
  int32_t law;
  // `PLANE`: angle from straight down, rad; positive towards positive x.
  double angle;
  // `ELEMENT`, `SOURCE`: lateral position, m.
  double x;
  // `ELEMENT`, `SOURCE`: depth, m.
  double z;
  // `DELAYS`: the time at which each element fires, s; NaN for a silent element.
  const double *delays;
  // Time of record sample 0 after the wave passes the law's origin, s.
  double t0;
} bonebeam_wave;

// A position and a direction: of an element, or of a line where it leaves.
typedef struct {
  // Lateral position, m.
  double x;
  // Depth, m.
  double z;
  // Angle from straight down, rad; positive towards positive x: of an element that of its normal.
  double angle;
} bonebeam_element;

// One scan line of one transmit.
typedef struct {
  // The transmit.
  bonebeam_wave wave;
  // Where the line leaves, and its direction.
  bonebeam_element origin;
  // Linear array: lateral positions of all elements, m, ascending and evenly spaced. Null for other arrays.
  const double *element_x;
  // Other arrays: all elements along a line or an arc, from left to right.
  const bonebeam_element *elements;
  // Other arrays: the distance of neighbouring elements along the array, m.
  double pitch;
  // The elements to compute.
  bonebeam_range active;
  // Not 0 adds to the output, for the second and later ones of several transmits.
  int32_t add;
} bonebeam_scan_line;

// Evenly spaced positions: `first + k·step` for `k` below `count`.
typedef struct {
  // The position of index 0, m.
  double first;
  // The distance of neighbours, m; positive.
  double step;
  // The number of positions.
  size_t count;
} bonebeam_axis;

// The I/Q of one transmit: complex numbers, or counts of 16 bits.
typedef struct {
  // Complex numbers; null for counts.
  const bonebeam_complex *samples;
  // I and Q in turn, if `samples` is null.
  const int16_t *counts;
  // The value of one count.
  float scale;
  // One of `bonebeam_layout`.
  int32_t layout;
} bonebeam_iq_record;

// A scan of I/Q by a linear array that is centred on 0. SI units.
typedef struct {
  // The delay stage.
  bonebeam_delay_parameters delay;
  // The receive aperture, of as many elements.
  bonebeam_aperture aperture;
  // Lateral positions of the lines, which go straight down.
  bonebeam_axis lines;
  // The least depth of the depth gate, m; 0 for both is no gate.
  double gate_from;
  // The greatest depth of the depth gate, m: samples outside are DAS.
  double gate_to;
  // Output samples that are aligned and beamformed at a time. It changes memory and time, never a line.
  size_t block;
} bonebeam_iq_scan;

// One transmit of a scan of I/Q.
typedef struct {
  // The transmitted wave.
  bonebeam_wave wave;
  // Its record.
  bonebeam_iq_record record;
} bonebeam_iq_wave;

// The parameters of phase symmetry.
typedef struct {
  // Rows of the image: 64, 128, 256, 512 or 1024.
  size_t rows;
  // Columns of the image, likewise.
  size_t columns;
  // Rows or columns that are transformed at a time. It changes memory and time, never the map.
  size_t strip;
  // Centre frequencies r₀ of the filters, cycles a pixel.
  const double *scales;
  // The number of scales, 1 to 8.
  size_t scale_count;
  // The noise threshold T_n, grey levels.
  float threshold;
} bonebeam_phase_symmetry_parameters;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Computes the active elements at each of `count` depths, m, below the position `beam`, in pitches from element 0.
bonebeam_status bonebeam_active_elements(const bonebeam_aperture *aperture,
                                         double beam,
                                         const double *depths,
                                         size_t count,
                                         bonebeam_range *active);

// Returns the bytes of a beamformer for lines with up to `elements` active elements.
size_t bonebeam_beamformer_bytes(const bonebeam_beamform_parameters *parameters, size_t elements);

// Places a beamformer in `memory`.
bonebeam_status bonebeam_beamformer_new(void *memory,
                                        size_t bytes,
                                        const bonebeam_beamform_parameters *parameters,
                                        size_t elements,
                                        bonebeam_beamformer **beamformer);

// Beamforms a line: `z[n]` from the aligned samples `x[n·elements]` to `x[n·elements + elements - 1]`, of which
// `active[n]` are used. `z` has the scale of `x`. With a `depth_step` of s, `z[i]` is sample `n = i·s`, and there are
// `samples/s` of them, rounded up.
//
// `adaptive`: a depth gate. Samples outside are DAS, and need not fit the beamformer's number of elements. Null:
// all samples are adaptive.
bonebeam_status bonebeam_beamformer_line(bonebeam_beamformer *beamformer,
                                         const bonebeam_complex *x,
                                         size_t samples,
                                         size_t elements,
                                         const bonebeam_range *active,
                                         const bonebeam_range *adaptive,
                                         bonebeam_complex *z);

// Returns the bytes of a delay stage for RF.
size_t bonebeam_delay_bytes(const bonebeam_delay_parameters *parameters);

// Places a delay stage for RF in `memory`.
bonebeam_status bonebeam_delay_new(void *memory,
                                   size_t bytes,
                                   const bonebeam_delay_parameters *parameters,
                                   bonebeam_delay **delay);

// Changes a stage's parameters. The filters are kept if rates, frequency, taps and precision stay the same; a
// change of the others is cheap. The stage's memory limits the new sizes: for the largest ones, give
// `bonebeam_delay_new` the bytes that these need. If the parameters are refused, the stage stays as it was.
bonebeam_status bonebeam_delay_set(bonebeam_delay *delay, const bonebeam_delay_parameters *parameters);

// Aligns one scan line: `out[n·elements + m]` is the analytic sample of element `m` at output sample `n`.
// `rf` is `[element][record sample]`.
bonebeam_status bonebeam_delay_line(bonebeam_delay *delay,
                                    const bonebeam_scan_line *line,
                                    const float *rf,
                                    bonebeam_complex *out);

// Computes `|z|` of `length` samples.
bonebeam_status bonebeam_envelope(const bonebeam_complex *z, size_t length, float *out);

// Returns the largest of `length` envelopes; 0 for a null pointer.
float bonebeam_largest(const float *envelopes, size_t length);

// Computes grey levels 0 to 255: decibels relative to `reference`, of which `dynamic_range` dB are shown.
// `logarithm` is one of `bonebeam_logarithm`.
bonebeam_status bonebeam_log_compression(int32_t logarithm,
                                         const float *envelopes,
                                         size_t length,
                                         float reference,
                                         float dynamic_range,
                                         float *out);

// Resamples grey levels of lines, `[beam][sample]`, to pixels `[row][column]`; 0 beyond the lines.
bonebeam_status bonebeam_resample(const float *levels,
                                  const bonebeam_axis *beams,
                                  const bonebeam_axis *samples,
                                  const bonebeam_axis *rows,
                                  const bonebeam_axis *columns,
                                  float *out);

// Computes the median of 3 × 3 pixels, for an image `[row][column]`.
bonebeam_status bonebeam_median(const float *image, size_t rows, size_t columns, float *out);

// Returns the bytes of a delay stage for I/Q.
size_t bonebeam_iq_bytes(const bonebeam_delay_parameters *parameters);

// Places a delay stage for I/Q in `memory`.
bonebeam_status bonebeam_iq_new(void *memory,
                                size_t bytes,
                                const bonebeam_delay_parameters *parameters,
                                bonebeam_iq **iq);

// Aligns one scan line of I/Q: `out` as of `bonebeam_delay_line`.
bonebeam_status bonebeam_iq_line(bonebeam_iq *iq,
                                 const bonebeam_scan_line *line,
                                 const bonebeam_iq_record *record,
                                 bonebeam_complex *out);

// Returns the bytes of the lines of a scan of I/Q.
size_t bonebeam_iq_lines_bytes(const bonebeam_iq_scan *scan, const bonebeam_beamform_parameters *beamformer);

// Places the lines of a scan of I/Q in `memory`.
bonebeam_status bonebeam_iq_lines_new(void *memory,
                                      size_t bytes,
                                      const bonebeam_iq_scan *scan,
                                      const bonebeam_beamform_parameters *beamformer,
                                      bonebeam_iq_lines **lines);

// Computes line `index`, the mean over `count` transmits. `z` has `output_samples` numbers, over the `depth_step` and
// rounded up if there is one; they may be changed in part if something is refused.
bonebeam_status bonebeam_iq_lines_line(bonebeam_iq_lines *lines,
                                       size_t index,
                                       const bonebeam_iq_wave *waves,
                                       size_t count,
                                       bonebeam_complex *z);

// Returns the bytes of phase symmetry that are best in fast memory: they grow with the strip.
size_t bonebeam_phase_symmetry_bytes(const bonebeam_phase_symmetry_parameters *parameters);

// Returns the bytes of phase symmetry that may be in slow memory: they grow with the image.
size_t bonebeam_phase_symmetry_slow_bytes(const bonebeam_phase_symmetry_parameters *parameters);

// Places phase symmetry in `memory` and `slow`. The scales are not used afterwards.
bonebeam_status bonebeam_phase_symmetry_new(void *memory,
                                            size_t bytes,
                                            void *slow,
                                            size_t slow_bytes,
                                            const bonebeam_phase_symmetry_parameters *parameters,
                                            bonebeam_phase_symmetry **phase_symmetry);

// Computes the map of an image of grey levels 0 to 255: at least 0, below 1. Both are `[row][column]`.
bonebeam_status bonebeam_phase_symmetry_map(bonebeam_phase_symmetry *phase_symmetry, const float *image, float *map);

// Computes the elements of a convex array, `pitch` m apart along an arc of `radius` m with its middle at x = 0, z = 0.
bonebeam_status bonebeam_convex_array(double pitch, double radius, bonebeam_element *elements, size_t count);

// Computes the origin of a line along the array's normal at `position`, in elements from element 0. The array has
// `count` elements, `pitch` m apart.
bonebeam_status bonebeam_normal(const bonebeam_element *elements,
                                size_t count,
                                double pitch,
                                double position,
                                bonebeam_element *origin);

// Returns the meaning of a status in English, for logs. `status` may be any number.
const char *bonebeam_status_text(int32_t status);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BONEBEAM_H */
