//! Meaning of the G words that only some controls have.

use crate::simulation::gcode::Dialect;
use crate::simulation::interpreter::spline::Spline;
use crate::simulation::interpreter::vendor_codes::{VendorCode, VendorModal};
use crate::simulation::interpreter::words::{Meaning, Mode, NO_GROUP, Special};

const PROBING: VendorCode = VendorCode::Unsupported(
    "probing: the point of contact is unknown, so the move is left out, its time is missing, and the tool does not move",
);
const MEASURING: VendorCode =
    VendorCode::Unsupported("measuring cycle: not modelled, its moves are missing from the time");
const POCKET: VendorCode =
    VendorCode::Unsupported("pocket: not modelled, its moves are missing from the time");
const THREAD: VendorCode = VendorCode::Unsupported(
    "threading (motion coupled to the spindle): not modelled, its moves are missing from the time",
);
const TAPPING_BY_PECKS: VendorCode =
    VendorCode::Unsupported("tapping with chip breaking: not modelled, its holes are missing from the time");

/// Returns the modal group and meaning of a G word, given ten times its number, if the dialect has its own
/// meaning; `None` if the meaning of ISO holds.
pub(crate) fn meaning(dialect: Dialect, tenths: u16) -> Option<(usize, Meaning)> {
    use Meaning::{Neutral, Transformation, TransformationAbout, WorkOffset};
    let special = |word| Some((0, Meaning::Special(Special::Vendor(word))));
    let modal = |group, word| Some((group, Meaning::Vendor(word)));
    match (dialect, tenths) {
        (Dialect::Siemens | Dialect::Klartext | Dialect::HeidenhainIso, _) => None,

        (Dialect::Okuma, 150 | 160) => modal(12, VendorModal::OffsetByH),
        (Dialect::Okuma, 530 | 540 | 550 | 560 | 570 | 580 | 590) => modal(8, VendorModal::LengthByH),
        (Dialect::Okuma, 710) => special(VendorCode::ReturnLevel),
        (Dialect::Okuma, 2840) => modal(9, VendorModal::RigidTap(840)),
        (Dialect::Okuma, 2730 | 2830) => special(TAPPING_BY_PECKS),
        (Dialect::Okuma, 110) => Some((NO_GROUP, TransformationAbout("parallel shift and rotation"))),
        (Dialect::Okuma, 620) => Some((NO_GROUP, TransformationAbout("mirror image"))),
        (Dialect::Okuma, 680) => Some((NO_GROUP, TransformationAbout("conversion of coordinates"))),
        (Dialect::Okuma, 1310) => modal(
            NO_GROUP,
            VendorModal::NotModelled(
                "G131",
                "high-speed contouring is not modelled: the machine's tolerance holds",
            ),
        ),

        (Dialect::LinuxCnc | Dialect::Iso, 52) => Some((1, Meaning::Motion(Mode::Spline(Spline::Nurbs)))),
        (Dialect::LinuxCnc | Dialect::Iso, 53) => Some((0, Meaning::Special(Special::NurbsEnd))),
        (Dialect::LinuxCnc | Dialect::Iso, 62) => {
            Some((1, Meaning::Motion(Mode::Spline(Spline::GivenKnots))))
        }
        (Dialect::LinuxCnc, 63) => Some((1, Meaning::NeutralAbout)),
        (Dialect::LinuxCnc, 70) => Some((NO_GROUP, Transformation("X words as diameters"))),
        (Dialect::LinuxCnc, 80) => Some((NO_GROUP, Neutral)),
        (Dialect::LinuxCnc | Dialect::Grbl, 281 | 301) => special(VendorCode::KeepReference),
        (Dialect::Mach, 281 | 301) => special(VendorCode::Unsupported(
            "homing: the switches' positions are unknown, so its moves are missing from the time and the tool does not move",
        )),
        (Dialect::Mach, 120 | 130) => special(POCKET),
        (Dialect::Mach, 700 | 710) => Some((6, Meaning::Inch(tenths == 700))),
        (_, 311..=313) => special(PROBING),
        (_, 320) => special(THREAD),

        (Dialect::Iso, 120 | 130 | 1500) => special(POCKET),
        (Dialect::Iso, 350 | 360 | 370 | 1360) => special(MEASURING),
        (Dialect::Iso, 270) => {
            special(VendorCode::Unsupported("check of the reference point: the move to it is not timed"))
        }
        (Dialect::Iso, 290) => special(VendorCode::Unsupported(
            "return from the reference point: not modelled, the tool does not move",
        )),
        (Dialect::Iso, 470) => {
            special(VendorCode::Unsupported("engraving: not modelled, its moves are missing from the time"))
        }
        (Dialect::Iso, 600) => special(VendorCode::FromOneSide),
        (Dialect::Iso, 700 | 710 | 720) => special(VendorCode::BoltHoles),
        (Dialect::Iso, 842) => modal(9, VendorModal::RigidTap(840)),
        (Dialect::Iso, 843) => modal(9, VendorModal::RigidTap(740)),
        (Dialect::Iso, 1000) => special(VendorCode::OneTouchChange),
        (Dialect::Iso, 1010) => Some((NO_GROUP, Meaning::Special(Special::Mirror))),
        (Dialect::Iso, 1100 | 1110 | 1140..=1290) if tenths.is_multiple_of(10) => {
            modal(12, VendorModal::OffsetByCode)
        }
        (Dialect::Iso, 1030) => modal(
            NO_GROUP,
            VendorModal::NotModelled(
                "G103",
                "the program's limit of look-ahead is not modelled; interpolator.look_ahead_blocks would limit it throughout",
            ),
        ),
        (Dialect::Okuma, 1540) => Some((12, WorkOffset)),
        _ => None,
    }
}
