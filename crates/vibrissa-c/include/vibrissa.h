/* Whisker mechanics and the calibration of a sensor: a uniform straight clamped whisker under one contact. All numbers are SI.
   Made by `cbindgen --crate vibrissa-c`; see crates/vibrissa-c. */

#ifndef VIBRISSA_H
#define VIBRISSA_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// The call was done.
#define VIBRISSA_OK 0

// A pointer is null.
#define VIBRISSA_NULL -1

// No contact explains it: the moment is beyond all that the whisker can have, or the point out of its reach.
#define VIBRISSA_NONE -2

// A number is not finite, or out of its range.
#define VIBRISSA_RANGE -3

// The flux is more than 5 % beyond the calibrated range.
#define VIBRISSA_BEYOND -4

// A uniform straight clamped whisker under one frictionless contact, in its own frame: base at the origin, undeflected along +x.
typedef struct {
  // Force along the whisker's normal at the contact (N).
  double force;
  // Arc length from the base to the contact (m).
  double arc_length;
  // Slope at the contact (rad), counter-clockwise.
  double slope;
  // The contact (m).
  double x;
  // The contact (m).
  double y;
  // Moment about the base (N m), counter-clockwise.
  double moment;
} VibrissaBend;

// The calibration of one axis: `moment` of a `cal.json`, for the inputs `bx`, `by`, `bz`.
typedef struct {
  // Flux without contact along the chip's axes (T).
  double rest[3];
  // Direction in which contact moves it, a unit vector.
  double direction[3];
  // Middle and half width of the calibrated range (T).
  double range[2];
  // Moment (N m) by rising power; zeros where the file has fewer.
  double coefficients[6];
} VibrissaCalibration;

// The calibration of both transverse axes: `plane` of a `cal.json`, for the inputs `bx`, `by`, `bz`.
typedef struct {
  // Flux without contact along the chip's axes (T).
  double rest[3];
  // Directions of both signals (N m/T): `directions`.
  double directions[2][3];
  // Middle and half width of each calibrated range (N m): `ranges`.
  double ranges[2][2];
  // Both moments (N m) by 1, u, v, u², uv, v², u³, u²v, uv², v³: `coefficients`.
  double coefficients[2][10];
} VibrissaPlane;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The whisker under a force (N) at an arc length (m), with a flexural rigidity E I (N m²).
int32_t vibrissa_by_force(double rigidity, double force, double arc_length, VibrissaBend *out);

// The whisker with a moment (N m) about its base and a contact at an arc length (m). There are two such shapes: the one that is bent less,
// and the one that is bent more (`curled`).
int32_t vibrissa_by_moment(double rigidity,
                           double moment,
                           double arc_length,
                           bool curled,
                           VibrissaBend *out);

// The whisker of a length (m) that a point (m) of its own frame holds.
int32_t vibrissa_by_point(double rigidity, double length, double x, double y, VibrissaBend *out);

// The moment (N m) of a flux along the chip's axes (T, three numbers), by the arithmetic of `vibrissa calibrate`.
int32_t vibrissa_moment(const VibrissaCalibration *calibration,
                        const double *flux,
                        double *moment);

// Both moments (N m, two numbers: in the whisker's plane x-y, and across it) of a flux along the chip's axes (T, three numbers), by the
// arithmetic of `vibrissa calibrate`. The whisker bends in the plane at the angle `atan2(moments[1], moments[0])` from left towards up, by the
// moment `hypot(moments[0], moments[1])`.
int32_t vibrissa_moments(const VibrissaPlane *plane, const double *flux, double *moments);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VIBRISSA_H */
