//! Exported functions: pointers to references, once, and everything else to the library.
//!
//! This is the only file that says `unsafe`: a name is exported without mangling, and a pointer of C becomes a reference. A null pointer is an
//! answer, [`VIBRISSA_NULL`]; any other pointer must be that of a value of its type, as every C function demands.
#![allow(unsafe_code, reason = "a C interface takes pointers and exports plain names")]

use vibrissa_beam::beam::normal::{self, Branch, NormalBend};
use vibrissa_beam::plane::Vec2;
use vibrissa_beam::sensing::SURFACE_TERMS;
use vibrissa_head::calibration::{CURVE_TERMS, Calibration, Moments, Response, Signal};

/// The call was done.
pub const VIBRISSA_OK: i32 = 0;
/// A pointer is null.
pub const VIBRISSA_NULL: i32 = -1;
/// No contact explains it: the moment is beyond all that the whisker can have, or the point out of its reach.
pub const VIBRISSA_NONE: i32 = -2;
/// A number is not finite, or out of its range.
pub const VIBRISSA_RANGE: i32 = -3;
/// The flux is more than 5 % beyond the calibrated range.
pub const VIBRISSA_BEYOND: i32 = -4;

/// A uniform straight clamped whisker under one frictionless contact, in its own frame: base at the origin, undeflected along +x.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VibrissaBend {
    /// Force along the whisker's normal at the contact (N).
    pub force: f64,
    /// Arc length from the base to the contact (m).
    pub arc_length: f64,
    /// Slope at the contact (rad), counter-clockwise.
    pub slope: f64,
    /// The contact (m).
    pub x: f64,
    /// The contact (m).
    pub y: f64,
    /// Moment about the base (N m), counter-clockwise.
    pub moment: f64,
}

/// The calibration of one axis: `moment` of a `cal.json`, for the inputs `bx`, `by`, `bz`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VibrissaCalibration {
    /// Flux without contact along the chip's axes (T).
    pub rest: [f64; 3],
    /// Direction in which contact moves it, a unit vector.
    pub direction: [f64; 3],
    /// Middle and half width of the calibrated range (T).
    pub range: [f64; 2],
    /// Moment (N m) by rising power; zeros where the file has fewer.
    pub coefficients: [f64; 6],
}

/// The calibration of both transverse axes: `plane` of a `cal.json`, for the inputs `bx`, `by`, `bz`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VibrissaPlane {
    /// Flux without contact along the chip's axes (T).
    pub rest: [f64; 3],
    /// Directions of both signals (N m/T): `directions`.
    pub directions: [[f64; 3]; 2],
    /// Middle and half width of each calibrated range (N m): `ranges`.
    pub ranges: [[f64; 2]; 2],
    /// Both moments (N m) by 1, u, v, u², uv, v², u³, u²v, uv², v³: `coefficients`.
    pub coefficients: [[f64; 10]; 2],
}

impl From<NormalBend> for VibrissaBend {
    fn from(bend: NormalBend) -> Self {
        let NormalBend { force, s_a, phi_a, contact, moment, .. } = bend;
        Self { force, arc_length: s_a, slope: phi_a, x: contact.x, y: contact.y, moment }
    }
}

const _: () = assert!(CURVE_TERMS == 6 && SURFACE_TERMS == 10);

/// The value to write where a pointer of C points.
fn place<'a, T>(pointer: *mut T) -> Option<&'a mut T> {
    // SAFETY: the header demands null or a value of this type that nobody else uses during the call.
    unsafe { pointer.as_mut() }
}

/// The value where a pointer of C points.
fn value<'a, T>(pointer: *const T) -> Option<&'a T> {
    // SAFETY: the header demands null or a value of this type.
    unsafe { pointer.as_ref() }
}

fn positive(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite() && *value > 0.0)
}

fn answer(out: *mut VibrissaBend, right: bool, bend: impl FnOnce() -> Option<NormalBend>) -> i32 {
    let Some(out) = place(out) else { return VIBRISSA_NULL };
    if !right {
        return VIBRISSA_RANGE;
    }
    let Some(bend) = bend() else { return VIBRISSA_NONE };
    *out = bend.into();
    VIBRISSA_OK
}

fn branch(curled: bool) -> Branch {
    if curled { Branch::Curled } else { Branch::Least }
}

/// The whisker under a force (N) at an arc length (m), with a flexural rigidity E I (N m²).
#[unsafe(no_mangle)]
pub extern "C" fn vibrissa_by_force(rigidity: f64, force: f64, arc_length: f64, out: *mut VibrissaBend) -> i32 {
    let right = positive(&[rigidity, arc_length]) && force.is_finite();
    answer(out, right, || normal::by_force(rigidity, force, arc_length))
}

/// The whisker with a moment (N m) about its base and a contact at an arc length (m). There are two such shapes: the one that is bent less,
/// and the one that is bent more (`curled`).
#[unsafe(no_mangle)]
pub extern "C" fn vibrissa_by_moment(
    rigidity: f64,
    moment: f64,
    arc_length: f64,
    curled: bool,
    out: *mut VibrissaBend,
) -> i32 {
    let right = positive(&[rigidity, arc_length]) && moment.is_finite();
    answer(out, right, || normal::by_moment(rigidity, moment, arc_length, branch(curled)))
}

/// The whisker of a length (m) that a point (m) of its own frame holds.
#[unsafe(no_mangle)]
pub extern "C" fn vibrissa_by_point(rigidity: f64, length: f64, x: f64, y: f64, out: *mut VibrissaBend) -> i32 {
    let right = positive(&[rigidity, length]) && x.is_finite() && y.is_finite();
    answer(out, right, || normal::by_point(rigidity, length, Vec2::new(x, y), Branch::Least))
}

/// The moment (N m) of a flux along the chip's axes (T, three numbers), by the arithmetic of `vibrissa calibrate`.
#[unsafe(no_mangle)]
pub extern "C" fn vibrissa_moment(calibration: *const VibrissaCalibration, flux: *const f64, moment: *mut f64) -> i32 {
    let (Some(given), Some(flux), Some(moment)) = (value(calibration), value(flux.cast::<[f64; 3]>()), place(moment))
    else {
        return VIBRISSA_NULL;
    };
    let signal = Signal { direction: given.direction, range: given.range };
    let response = Response::Line(signal, given.coefficients);
    calibrated(&Calibration { rest: given.rest, response }, *flux, |found| *moment = found.moment)
}

/// Both moments (N m, two numbers: in the whisker's plane x-y, and across it) of a flux along the chip's axes (T, three numbers), by the
/// arithmetic of `vibrissa calibrate`. The whisker bends in the plane at the angle `atan2(moments[1], moments[0])` from left towards up, by the
/// moment `hypot(moments[0], moments[1])`.
#[unsafe(no_mangle)]
pub extern "C" fn vibrissa_moments(plane: *const VibrissaPlane, flux: *const f64, moments: *mut f64) -> i32 {
    let places = place(moments.cast::<[f64; 2]>());
    let (Some(given), Some(flux), Some(moments)) = (value(plane), value(flux.cast::<[f64; 3]>()), places) else {
        return VIBRISSA_NULL;
    };
    let signal = |k: usize| Signal { direction: given.directions[k], range: given.ranges[k] };
    let response = Response::Plane([signal(0), signal(1)], given.coefficients);
    calibrated(&Calibration { rest: given.rest, response }, *flux, |found| {
        *moments = [found.moment, found.across.unwrap_or(0.0)];
    })
}

fn calibrated(held: &Calibration, flux: [f64; 3], tell: impl FnOnce(Moments)) -> i32 {
    if !held.is_valid() || !flux.iter().all(|value| value.is_finite()) {
        return VIBRISSA_RANGE;
    }
    let Some(found) = held.moments(flux) else { return VIBRISSA_BEYOND };
    tell(found);
    VIBRISSA_OK
}

/// What a library without an operating system brings along: no memory, and a panic that waits for the watchdog.
#[cfg(all(feature = "firmware", not(feature = "std")))]
mod alone {
    use core::alloc::{GlobalAlloc, Layout};

    struct Nothing;

    // SAFETY: no memory is ever given, so none can be given wrongly.
    unsafe impl GlobalAlloc for Nothing {
        unsafe fn alloc(&self, _: Layout) -> *mut u8 {
            core::ptr::null_mut()
        }

        unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
    }

    #[global_allocator]
    static NOTHING: Nothing = Nothing;

    #[panic_handler]
    fn wait(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            core::hint::spin_loop();
        }
    }
}
