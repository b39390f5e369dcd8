/** @file
 * bonebeam for C. Made by cbindgen from bonebeam-c/src: do not edit.
 *
 * MIT OR Apache-2.0
 *
 * Objects. An object lives in memory of the caller. For an object X:
 *
 * - bonebeam_X_bytes returns the bytes that a configuration needs; 0 if the configuration is null or not valid.
 * - bonebeam_X_new checks the configuration, places the object in `memory`, and writes the handle. `memory` has `bytes`
 *   bytes and is aligned to BONEBEAM_ALIGN. Null or unaligned memory gives BONEBEAM_STATUS_POINTER, memory that is too
 *   small BONEBEAM_STATUS_STORAGE. Data behind the pointers of a configuration is copied.
 * - The other functions take the handle. Nothing must be freed: the object ends when the memory is used again.
 *
 * The memory may be static, as on a microcontroller without a heap:
 *
 *     static alignas(BONEBEAM_ALIGN) unsigned char memory[7168];
 *     status = bonebeam_beamformer_new(memory, sizeof memory, &parameters, 32, &beamformer);
 *
 * bonebeam_X_bytes on a workstation gives this number (here with K = 2): 32-bit processors need as much or less.
 *
 * Calls. A status other than 0 leaves the outputs unchanged, unless a function says otherwise. A null or unaligned
 * pointer gives BONEBEAM_STATUS_POINTER, and so does an output that overlaps an input array of the same call. An
 * integer that names an enumerator and has another value gives BONEBEAM_STATUS_PARAMETER.
 *
 * The caller guarantees the rest: a pointer leads to as many values as its function says, no array overlaps an object's
 * memory, and one thread at a time uses an object. */

#ifndef BONEBEAM_H
#define BONEBEAM_H

#include <stddef.h>
#include <stdint.h>

/// Alignment of the memory of every object, bytes.
#define BONEBEAM_ALIGN 64

/// Maximum number of transmits compounded in a line.
#define BONEBEAM_WAVES 16

/// Major version of the header.
#define BONEBEAM_VERSION_MAJOR 0

/// Minor version of the header.
#define BONEBEAM_VERSION_MINOR 1

/// Patch version of the header.
#define BONEBEAM_VERSION_PATCH 0

/// The result of a call.
enum bonebeam_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /// Done.
  BONEBEAM_STATUS_OK = 0,
  /// A parameter is outside its range.
  BONEBEAM_STATUS_PARAMETER = 1,
  /// An array's length does not match the shapes.
  BONEBEAM_STATUS_LENGTH = 2,
  /// A size exceeds a capacity.
  BONEBEAM_STATUS_CAPACITY = 3,
  /// An input sample is NaN or infinite.
  BONEBEAM_STATUS_NON_FINITE = 4,
  /// External memory could not be read or written.
  BONEBEAM_STATUS_MEMORY = 5,
  /// A pointer is null or not aligned, or an output overlaps an input.
  BONEBEAM_STATUS_POINTER = 6,
  /// The object's memory is smaller than the result of its `_bytes` function.
  BONEBEAM_STATUS_STORAGE = 7,
  /// An error without a number in this version.
  BONEBEAM_STATUS_OTHER = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_status bonebeam_status;
#else
typedef int32_t bonebeam_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The covariance that adaptive methods use.
typedef enum {
  /// Forward-backward averaging: real arithmetic, the faster.
  BONEBEAM_COVARIANCE_FORWARD_BACKWARD = 0,
  /// Forward averaging, unless the library was built without its feature `forward`.
  BONEBEAM_COVARIANCE_FORWARD = 1,
} bonebeam_covariance;

/// The transmitted waves.
typedef enum {
  /// A beam focused along the line.
  BONEBEAM_LAW_FOCUSED = 0,
  /// A plane wave at `angle`.
  BONEBEAM_LAW_PLANE = 1,
  /// A single element at `x`, `z`.
  BONEBEAM_LAW_ELEMENT = 2,
  /// A virtual source at `x`, `z`.
  ///
  /// `z` ≤ 0: diverging. `z` > 0: converging on the source, then diverging.
  BONEBEAM_LAW_SOURCE = 3,
  /// The first arrival from elements that fire at `delays`.
  BONEBEAM_LAW_DELAYS = 4,
} bonebeam_law;

/// The order of samples in memory.
typedef enum {
  /// `[element][sample]`, as in recordings.
  BONEBEAM_LAYOUT_PLANAR = 0,
  /// `[sample][element]`, as from a front end.
  BONEBEAM_LAYOUT_INTERLEAVED = 1,
} bonebeam_layout;

/// The computation of decibels.
typedef enum {
  /// libm's logarithm.
  BONEBEAM_LOGARITHM_EXACT = 0,
  /// A polynomial, with fewer instructions.
  ///
  /// `Logarithm::Polynomial` in the core's documentation gives the error.
  BONEBEAM_LOGARITHM_POLYNOMIAL = 1,
} bonebeam_logarithm;

/// Interpolation of I/Q.
///
/// `IqInterpolation::for_band` in the core's documentation gives the cheapest one for a bandwidth.
typedef enum {
  /// Linear interpolation.
  BONEBEAM_INTERPOLATION_LINEAR = 0,
  /// Cubic interpolation through four samples.
  BONEBEAM_INTERPOLATION_CUBIC = 1,
  /// A windowed sinc of 12 taps.
  BONEBEAM_INTERPOLATION_SINC = 2,
  /// Linear interpolation in fixed point, for counts only.
  ///
  /// `IqInterpolation::LinearFixed` in the core's documentation gives the limits.
  BONEBEAM_INTERPOLATION_LINEAR_FIXED = 3,
} bonebeam_interpolation;

/// A beamformer of aligned samples.
typedef struct bonebeam_beamformer bonebeam_beamformer;

/// A delay stage for RF.
typedef struct bonebeam_delay bonebeam_delay;

/// A frame: channel data line by line, then image, bone map and surface.
///
/// Image and map are in the frame's memory, and valid until the frame is used again.
typedef struct bonebeam_frame bonebeam_frame;

/// The lines of a scan of I/Q: delay stage, apertures and beamformer.
typedef struct bonebeam_iq_lines bonebeam_iq_lines;

/// A delay stage for I/Q.
typedef struct bonebeam_iq bonebeam_iq;

/// Phase symmetry of images of one size.
typedef struct bonebeam_phase_symmetry bonebeam_phase_symmetry;

/// An aperture that grows with depth.
typedef struct {
  /// Elements of the array.
  size_t elements;
  /// Distance of neighbouring elements, m.
  double pitch;
  /// F-number: depth divided by the width of the aperture.
  double f_number;
  /// Minimum number of active elements; fewer at the ends of the array.
  size_t min_elements;
} bonebeam_aperture;

/// Consecutive elements or samples.
typedef struct {
  /// Index of the first element or sample.
  size_t first;
  /// Number of elements or samples.
  size_t count;
} bonebeam_range;

/// A parameter by its name in the tables of docs/numerics.md.
///
/// For instance "temporal_half_window", "diagonal_loading" or "subaperture_ratio". If a name occurs several times, the
/// last value counts.
typedef struct {
  /// The name.
  const char *name;
  /// The value.
  double value;
} bonebeam_number;

/// The parameters of a beamformer.
typedef struct {
  /// Key of the method: "das", "mv", "esmv-rank1" and others.
  ///
  /// docs/numerics.md has the tables of all keys.
  const char *method;
  /// Key of the postfilter in the same tables, or null for none.
  ///
  /// For instance "coherence-factor".
  const char *postfilter;
  /// Key of the apodization in the same tables, or null for none.
  ///
  /// For instance "hann".
  const char *apodization;
  /// Argument of the method, if the tables give one.
  ///
  /// β, a rank, or a number of steps.
  double argument;
  /// One of `bonebeam_covariance`.
  int32_t covariance;
  /// Parameters other than their defaults, `count` of them; null for none.
  const bonebeam_number *numbers;
  /// Number of `numbers`.
  size_t count;
  /// Sub-lines of each line of a scan: 1, 2, 4, 8, 16 or 32; 0 is 1.
  ///
  /// Sub-lines are directions within the line's cell that share its covariance. More than 1 need the library's
  /// feature `sub-lines`, and work only in frames and lines of scans. For I/Q their phases are those of the
  /// demodulation frequency.
  size_t sub_lines;
} bonebeam_beamform_parameters;

/// A complex number.
typedef struct {
  /// Real part.
  float re;
  /// Imaginary part.
  float im;
} bonebeam_complex;

/// Parameters of a delay stage for RF or for I/Q. SI units.
typedef struct {
  /// Speed of sound, m/s.
  double sound_speed;
  /// Sampling rate of the record, Hz; for I/Q complex samples per second.
  double sampling_rate;
  /// RF: centre frequency of the pulse, Hz. I/Q: demodulation frequency, Hz.
  double frequency;
  /// Output rate, Hz; for RF at least a sixteenth of the sampling rate.
  double output_rate;
  /// Two-way time of output sample 0, s.
  double output_start;
  /// Output samples of a line.
  size_t output_samples;
  /// Elements of the array.
  size_t elements;
  /// Samples of each element's record.
  size_t record_samples;
  /// RF: non-zero taps on one side of the Hilbert transformer.
  ///
  /// 0 chooses them by the rates; a frame takes only that choice.
  size_t hilbert_taps;
  /// RF: not 0 computes the filters in single precision.
  ///
  /// For processors with doubles in software: far fewer instructions. The bits of lines differ.
  int32_t single_precision;
  /// I/Q: one of `bonebeam_interpolation`.
  int32_t interpolation;
} bonebeam_delay_parameters;

/// One transmit.
typedef struct {
  /// One of `bonebeam_law`.
  int32_t law;
  /// `PLANE`: angle from straight down, rad; positive towards positive x.
  double angle;
  /// `ELEMENT`, `SOURCE`: lateral position, m.
  double x;
  /// `ELEMENT`, `SOURCE`: depth, m.
  double z;
  /// `DELAYS`: the time at which each element fires, s; NaN for a silent element.
  const double *delays;
  /// Time of record sample 0 after the wave passes the law's origin, s.
  double t0;
} bonebeam_wave;

/// A position and a direction, of an element or of a line's origin.
typedef struct {
  /// Lateral position, m.
  double x;
  /// Depth, m.
  double z;
  /// Angle from straight down, rad; positive towards positive x.
  ///
  /// For an element the angle of its normal.
  double angle;
} bonebeam_element;

/// One scan line of one transmit.
typedef struct {
  /// The transmit.
  bonebeam_wave wave;
  /// Origin and direction of the line.
  bonebeam_element origin;
  /// Linear array: lateral positions of all elements, m. Null for other arrays.
  ///
  /// Ascending and evenly spaced.
  const double *element_x;
  /// Other arrays: all elements along a line or an arc, from left to right.
  const bonebeam_element *elements;
  /// Other arrays: the distance of neighbouring elements along the array, m.
  double pitch;
  /// The elements to compute.
  bonebeam_range active;
  /// Not 0: the line is added to the output, for transmits after the first.
  int32_t add;
} bonebeam_scan_line;

/// Evenly spaced positions: `first + k·step` for `k` below `count`.
typedef struct {
  /// Position of index 0, m.
  double first;
  /// Distance of neighbours, m; positive.
  double step;
  /// Number of positions.
  size_t count;
} bonebeam_axis;

/// A scan by a linear array that is centred on 0. SI units.
typedef struct {
  /// The delay stage.
  bonebeam_delay_parameters delay;
  /// The receive aperture, with the same number of elements.
  bonebeam_aperture aperture;
  /// Lateral positions of the lines, which go straight down.
  bonebeam_axis lines;
  /// Least depth of the depth gate, m; 0 for both depths means no gate.
  double gate_from;
  /// Greatest depth of the depth gate, m. Samples outside the gate are DAS.
  double gate_to;
  /// Number of output samples in a block of alignment and beamforming.
  ///
  /// It changes memory and time, never a line.
  size_t block;
} bonebeam_scan;

/// The parameters of phase symmetry.
typedef struct {
  /// Rows of the image: 64, 128, 256, 512 or 1024.
  size_t rows;
  /// Columns of the image: 64, 128, 256, 512 or 1024.
  size_t columns;
  /// Number of rows or columns that are transformed at a time.
  ///
  /// It changes memory and time, never the map.
  size_t strip;
  /// Centre frequencies r₀ of the filters, cycles per pixel.
  const double *scales;
  /// Number of scales, 1 to 8.
  size_t scale_count;
  /// Noise threshold T_n, grey levels.
  float threshold;
} bonebeam_phase_symmetry_parameters;

/// The parameters of a frame.
typedef struct {
  /// Records, lines, aperture and depth gate.
  bonebeam_scan scan;
  /// The beamformer.
  bonebeam_beamform_parameters beamformer;
  /// The image's size, and the filters of the bone map; `strip` is not used.
  bonebeam_phase_symmetry_parameters image;
  /// Level of black below the largest envelope, dB.
  float dynamic_range;
  /// Not 0: the image is filtered by a median of 3 × 3 pixels.
  int32_t median;
  /// Not 0: the image shows the RMS of sub-lines; else the largest.
  int32_t pool_by_rms;
  /// Not 0: the filters' gains are in tables, for faster maps of the same bits.
  int32_t gain_tables;
  /// Least depth of the surface, m.
  ///
  /// 0 for both depths means no surface, and no memory for it.
  double surface_from;
  /// Greatest depth of the surface, m; may be infinite.
  double surface_to;
  /// Half the time window of the surface's coherence, m; 0: no coherence.
  ///
  /// The detector's settings are for 0.4e-3. It costs one byte of memory per sample of all lines, and time per line.
  double surface_coherence;
} bonebeam_frame_parameters;

/// The field for which a configuration is refused.
typedef struct {
  /// The field's name, ended by 0; empty if no field is at fault.
  char name[48];
  /// Its value, or 0.
  double value;
  /// The accepted values in words, ended by 0; empty of a length or a capacity.
  char expected[112];
} bonebeam_refusal;

/// One transmit of a scan of RF.
typedef struct {
  /// The transmitted wave.
  bonebeam_wave wave;
  /// Its record, `[element][record sample]`.
  const float *rf;
} bonebeam_rf_wave;

/// The I/Q of one transmit: complex numbers, or counts of 16 bits.
typedef struct {
  /// Complex numbers; null for counts.
  const bonebeam_complex *samples;
  /// I and Q in turn, if `samples` is null.
  const int16_t *counts;
  /// The value of one count.
  float scale;
  /// One of `bonebeam_layout`.
  int32_t layout;
} bonebeam_iq_record;

/// One transmit of a scan of I/Q.
typedef struct {
  /// The transmitted wave.
  bonebeam_wave wave;
  /// Its record.
  bonebeam_iq_record record;
} bonebeam_iq_wave;

/// Called after each step of an image or a map, with the number of steps so far.
///
/// A step is less than a million instructions on a Cortex-M7, so that a watchdog can be reset in it. By vectors, a step
/// of a map is a filter. May be null.
typedef void (*bonebeam_progress)(void *context, size_t done);

/// The surface in a line.
typedef struct {
  /// Not 0: there is a surface. The other values are otherwise 0.
  int32_t found;
  /// Not 0: a piece of surface begins here.
  int32_t begins;
  /// Depth along the line, m.
  float depth;
  /// Confidence, 0 to 1.
  float confidence;
} bonebeam_point;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Computes the active elements at each of `count` depths, m.
///
/// `beam` is the lateral position, in pitches from element 0.
bonebeam_status bonebeam_active_elements(const bonebeam_aperture *aperture,
                                         double beam,
                                         const double *depths,
                                         size_t count,
                                         bonebeam_range *active);

/// Returns the bytes of a beamformer for up to `elements` active elements.
size_t bonebeam_beamformer_bytes(const bonebeam_beamform_parameters *parameters, size_t elements);

/// Places a beamformer in `memory`.
bonebeam_status bonebeam_beamformer_new(void *memory,
                                        size_t bytes,
                                        const bonebeam_beamform_parameters *parameters,
                                        size_t elements,
                                        bonebeam_beamformer **beamformer);

/// Beamforms a line: `z[n]` from aligned samples.
///
/// Sample n is `x[n·elements]` to `x[n·elements + elements - 1]`, of which `active[n]` are used. `z` has the scale of
/// `x`. With a `depth_step` of s, `z[i]` is sample `n = i·s`, and `z` has `samples/s` numbers, rounded up.
///
/// `adaptive`: a depth gate. Samples outside are DAS, and may have more active elements than the beamformer was made
/// for. Null: all samples are adaptive.
bonebeam_status bonebeam_beamformer_line(bonebeam_beamformer *beamformer,
                                         const bonebeam_complex *x,
                                         size_t samples,
                                         size_t elements,
                                         const bonebeam_range *active,
                                         const bonebeam_range *adaptive,
                                         bonebeam_complex *z);

/// Beamforms the samples of a line that are aligned so far.
///
/// The bits are those of `bonebeam_beamformer_line` for the whole line of `samples` samples. `x` has only the samples
/// `aligned`: sample n begins at `x[(n - aligned.first)·elements]`. `largest` is the largest magnitude of a real or
/// imaginary part of the whole line, which sets its working scale. With 0 it is that of `x`: bits may then differ for
/// samples 300 dB below it. `active` and `z` are those of the whole line.
/// Output is written to `z` from sample `*done` on, and `*done` becomes the first sample without output. Set `*done` to
/// 0 before the first call. With a `temporal_half_window` of K, `aligned` begins K samples before `*done` or earlier,
/// and a call leaves up to 3·K aligned samples for the next. In the last call, `aligned` ends with the line.
bonebeam_status bonebeam_beamformer_partial_line(bonebeam_beamformer *beamformer,
                                                 const bonebeam_complex *x,
                                                 bonebeam_range aligned,
                                                 size_t samples,
                                                 size_t elements,
                                                 float largest,
                                                 const bonebeam_range *active,
                                                 const bonebeam_range *adaptive,
                                                 size_t *done,
                                                 bonebeam_complex *z);

/// Returns the bytes of a delay stage for RF.
size_t bonebeam_delay_bytes(const bonebeam_delay_parameters *parameters);

/// Places a delay stage for RF in `memory`.
bonebeam_status bonebeam_delay_new(void *memory,
                                   size_t bytes,
                                   const bonebeam_delay_parameters *parameters,
                                   bonebeam_delay **delay);

/// Changes the parameters of a stage.
///
/// The filters are kept if rates, frequency, taps and precision stay the same; a change of other parameters is
/// cheap. The stage's memory limits the new sizes: for the largest ones, give `bonebeam_delay_new` the bytes that
/// they need. If the parameters are refused, the stage stays unchanged.
bonebeam_status bonebeam_delay_set(bonebeam_delay *delay, const bonebeam_delay_parameters *parameters);

/// Aligns one scan line of one transmit.
///
/// `out[n·elements + m]` is the analytic sample of element `m` at output sample `n`. `rf` is `[element][record
/// sample]`.
bonebeam_status bonebeam_delay_line(bonebeam_delay *delay,
                                    const bonebeam_scan_line *line,
                                    const float *rf,
                                    bonebeam_complex *out);

/// Aligns the samples in `block` of a line, with the bits of the whole line.
///
/// `out` has `block.count·elements` numbers. The whole record is checked, but its samples from
/// `bonebeam_delay_record_end` on may have any finite value.
bonebeam_status bonebeam_delay_block(bonebeam_delay *delay,
                                     const bonebeam_scan_line *line,
                                     const float *rf,
                                     bonebeam_range block,
                                     bonebeam_complex *out);

/// Computes the number of a record's first samples that a block of a line needs.
///
/// `block` is a range of the line's samples. It can be aligned once that number of samples is recorded. The cost is two
/// positions in doubles for each output sample: compute the number once for a scan.
bonebeam_status bonebeam_delay_record_end(const bonebeam_delay *delay,
                                          const bonebeam_scan_line *line,
                                          bonebeam_range block,
                                          size_t *samples);

/// Writes counts of 16 bits into a record of RF.
///
/// The samples in `block` of each element become `scale` times the counts. `layout` is one of `bonebeam_layout`, the
/// order of the block's `elements·block.count` counts. `rf` is `[element][record sample]`. The counts are those of a
/// whole record, or of a block of it as it arrives.
bonebeam_status bonebeam_rf_counts(const int16_t *counts,
                                   int32_t layout,
                                   float scale,
                                   bonebeam_range block,
                                   size_t elements,
                                   size_t record_samples,
                                   float *rf);

/// Returns the bytes of a frame of RF.
size_t bonebeam_frame_bytes(const bonebeam_frame_parameters *parameters);

/// Returns the bytes of a frame of I/Q.
size_t bonebeam_frame_iq_bytes(const bonebeam_frame_parameters *parameters);

/// Checks the configuration of a frame of RF: why `bonebeam_frame_new` refuses it.
bonebeam_status bonebeam_frame_check(const bonebeam_frame_parameters *parameters, bonebeam_refusal *refusal);

/// Checks the configuration of a frame of I/Q, as `bonebeam_frame_check`.
bonebeam_status bonebeam_frame_iq_check(const bonebeam_frame_parameters *parameters, bonebeam_refusal *refusal);

/// Places a frame of RF in `memory`.
bonebeam_status bonebeam_frame_new(void *memory,
                                   size_t bytes,
                                   const bonebeam_frame_parameters *parameters,
                                   bonebeam_frame **frame);

/// Places a frame of I/Q in `memory`.
bonebeam_status bonebeam_frame_iq_new(void *memory,
                                      size_t bytes,
                                      const bonebeam_frame_parameters *parameters,
                                      bonebeam_frame **frame);

/// Computes line `index` of a frame of RF, and keeps its envelope.
///
/// The line is the mean over `count` transmits. Lines may come in any order. A line that does not come keeps its
/// values of the last frame. `z`, unless null, receives the line: `output_samples` numbers; with a `depth_step`, their
/// number over the step, rounded up. With sub-lines it receives as many for each, `[sample][sub-line]`.
bonebeam_status bonebeam_frame_line(bonebeam_frame *frame,
                                    size_t index,
                                    const bonebeam_rf_wave *waves,
                                    size_t count,
                                    bonebeam_complex *z);

/// Computes line `index` of a frame of I/Q, as `bonebeam_frame_line`.
bonebeam_status bonebeam_frame_iq_line(bonebeam_frame *frame,
                                       size_t index,
                                       const bonebeam_iq_wave *waves,
                                       size_t count,
                                       bonebeam_complex *z);

/// Computes the image of the lines so far: `[row][column]`, grey levels 0 to 255.
///
/// Lines that never came are black. `context` is passed to `progress`.
bonebeam_status bonebeam_frame_image(bonebeam_frame *frame,
                                     bonebeam_progress progress,
                                     void *context,
                                     const float **image);

/// Computes the bone map of the last image.
///
/// It is `[row][column]`, at least 0 and below 1. `context` is passed to `progress`.
bonebeam_status bonebeam_frame_map(bonebeam_frame *frame, bonebeam_progress progress, void *context, const float **map);

/// Finds the bone surface in the lines so far: a point for each line.
///
/// The detector is made for a `dynamic_range` of 60 dB. A frame without a surface gives BONEBEAM_STATUS_PARAMETER.
bonebeam_status bonebeam_frame_surface(bonebeam_frame *frame, bonebeam_point *points);

/// Returns the positions of an image's rows and columns, m.
bonebeam_status bonebeam_frame_axes(bonebeam_frame *frame, bonebeam_axis *rows, bonebeam_axis *columns);

/// Computes `|z|` of `length` samples.
bonebeam_status bonebeam_envelope(const bonebeam_complex *z, size_t length, float *out);

/// Returns the largest of `length` envelopes; 0 for a null pointer.
float bonebeam_largest(const float *envelopes, size_t length);

/// Computes grey levels 0 to 255 from envelopes.
///
/// 255 is `reference`, and 0 is `dynamic_range` dB below it. `logarithm` is one of `bonebeam_logarithm`.
bonebeam_status bonebeam_log_compression(int32_t logarithm,
                                         const float *envelopes,
                                         size_t length,
                                         float reference,
                                         float dynamic_range,
                                         float *out);

/// Resamples grey levels of lines to pixels.
///
/// Input `[beam][sample]`, output `[row][column]`, 0 beyond the lines.
bonebeam_status bonebeam_resample(const float *levels,
                                  const bonebeam_axis *beams,
                                  const bonebeam_axis *samples,
                                  const bonebeam_axis *rows,
                                  const bonebeam_axis *columns,
                                  float *out);

/// Computes the median of 3 × 3 pixels, for an image `[row][column]`.
bonebeam_status bonebeam_median(const float *image, size_t rows, size_t columns, float *out);

/// Returns the bytes of a delay stage for I/Q.
size_t bonebeam_iq_bytes(const bonebeam_delay_parameters *parameters);

/// Places a delay stage for I/Q in `memory`.
bonebeam_status bonebeam_iq_new(void *memory,
                                size_t bytes,
                                const bonebeam_delay_parameters *parameters,
                                bonebeam_iq **iq);

/// Aligns one scan line of I/Q; `out` is as in `bonebeam_delay_line`.
bonebeam_status bonebeam_iq_line(bonebeam_iq *iq,
                                 const bonebeam_scan_line *line,
                                 const bonebeam_iq_record *record,
                                 bonebeam_complex *out);

/// Returns the bytes of the lines of a scan of I/Q.
size_t bonebeam_iq_lines_bytes(const bonebeam_scan *scan, const bonebeam_beamform_parameters *beamformer);

/// Places the lines of a scan of I/Q in `memory`.
bonebeam_status bonebeam_iq_lines_new(void *memory,
                                      size_t bytes,
                                      const bonebeam_scan *scan,
                                      const bonebeam_beamform_parameters *beamformer,
                                      bonebeam_iq_lines **lines);

/// Computes line `index`, the mean over `count` transmits.
///
/// `z` has `output_samples` numbers; with a `depth_step`, that number divided by the step, rounded up. With sub-lines
/// it has as many for each sub-line, `[sample][sub-line]`. An error may leave `z` partly changed.
bonebeam_status bonebeam_iq_lines_line(bonebeam_iq_lines *lines,
                                       size_t index,
                                       const bonebeam_iq_wave *waves,
                                       size_t count,
                                       bonebeam_complex *z);

/// Returns the bytes of fast memory for phase symmetry; they grow with the strip.
size_t bonebeam_phase_symmetry_bytes(const bonebeam_phase_symmetry_parameters *parameters);

/// Returns the bytes of slow memory for phase symmetry.
///
/// They grow with the image.
size_t bonebeam_phase_symmetry_slow_bytes(const bonebeam_phase_symmetry_parameters *parameters);

/// Places phase symmetry in `memory` and `slow`.
///
/// The array of scales is not used after the call.
bonebeam_status bonebeam_phase_symmetry_new(void *memory,
                                            size_t bytes,
                                            void *slow,
                                            size_t slow_bytes,
                                            const bonebeam_phase_symmetry_parameters *parameters,
                                            bonebeam_phase_symmetry **phase_symmetry);

/// Computes the map of an image of grey levels 0 to 255.
///
/// The map is at least 0 and below 1. Image and map are `[row][column]`.
bonebeam_status bonebeam_phase_symmetry_map(bonebeam_phase_symmetry *phase_symmetry, const float *image, float *map);

/// Computes the elements of a convex array.
///
/// They are `pitch` m apart along an arc of `radius` m with its middle at x = 0, z = 0.
bonebeam_status bonebeam_convex_array(double pitch, double radius, bonebeam_element *elements, size_t count);

/// Computes the origin of a line along the array's normal.
///
/// `position` is in elements from element 0. The array has `count` elements, `pitch` m apart.
bonebeam_status bonebeam_normal(const bonebeam_element *elements,
                                size_t count,
                                double pitch,
                                double position,
                                bonebeam_element *origin);

/// Returns the meaning of a status in English, for logs.
///
/// `status` may be any number.
const char *bonebeam_status_text(int32_t status);

/// Returns the version of the library, for instance "0.1.0".
///
/// It differs from the header's if the program was compiled with the header of another version.
const char *bonebeam_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BONEBEAM_H */
