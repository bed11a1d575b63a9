//! Addresses of more than one letter, as codes beyond those of the letters.
//!
//! A word stores its address in one byte: the letter for `A` to `Z`, a code of this table for the others.
//!
//! Sources: SINUMERIK 840D sl programming manual; TNC 640 Klartext manual; LinuxCNC 2.9.

/// The first code that is not a letter.
pub const FIRST_NAMED_CODE: u8 = 128;

macro_rules! addresses {
    ($($(#[$doc:meta])* $name:ident = $code:literal $written:literal,)*) => {
        $($(#[$doc])* pub const $name: u8 = $code;)*

        /// The codes with their spelling.
        pub const WRITTEN: &[(u8, &str)] = &[$(($code, $written)),*];
    };
}

addresses! {
    /// Radius of an arc.
    CIRCLE_RADIUS = 128 "CR",
    /// Rounding radius of the corner that follows.
    ROUNDING = 129 "RND",
    /// Modal rounding radius.
    MODAL_ROUNDING = 130 "RNDM",
    /// Chamfer by the length of its legs.
    CHAMFER_LEG = 131 "CHR",
    /// Chamfer by its own length.
    CHAMFER = 132 "CHF",
    /// Feedrate of roundings and chamfers.
    CORNER_FEED = 133 "FRC",
    /// Polar radius.
    POLAR_RADIUS = 134 "RP",
    /// Polar angle.
    POLAR_ANGLE = 135 "AP",
    /// Full turns of an arc beyond the first.
    TURNS = 136 "TURN",
    /// Opening angle of an arc.
    OPENING_ANGLE = 137 "AR",
    /// First coordinate of an intermediate point of an arc.
    MIDDLE_X = 138 "I1",
    /// Second coordinate of an intermediate point of an arc.
    MIDDLE_Y = 139 "J1",
    /// Third coordinate of an intermediate point of an arc.
    MIDDLE_Z = 140 "K1",
    /// Spindle position.
    SPINDLE_POSITION = 141 "SPOS",
    /// Smoothing distance along the path.
    SMOOTHING = 142 "ADIS",
    /// Smoothing distance of rapid moves.
    RAPID_SMOOTHING = 143 "ADISPOS",
    /// A tool by name: index of the text.
    TOOL_NAME = 144 "T",
    /// Sense of rotation of an arc: 1 counter-clockwise, −1 clockwise.
    SENSE = 145 "DR",
    /// The block makes no hole of the cycle in force.
    NO_CYCLE = 146 "NCYL",
    /// The number of a tool that is being defined.
    DEFINED_TOOL = 147 "",
    /// Radius of the tool, given in the program.
    TOOL_RADIUS = 148 "R",
    /// Length of the tool, given in the program.
    TOOL_LENGTH = 149 "L",
    /// Length of approach or departure.
    APPROACH_LENGTH = 150 "LEN",
    /// Angle of a straight line to the first axis of the plane.
    LINE_ANGLE = 163 "ANG",
    /// Feedrate for this block alone.
    BLOCK_FEED = 164 "FB",
    /// Rotation in the plane in force.
    PLANE_ANGLE = 165 "RPL",
    /// Side of the contour the tool is on: 1 left, −1 right, 0 no compensation.
    SIDE = 152 "R0",
    /// The move of the block is a rapid one.
    RAPID = 153 "FMAX",
    /// The feedrate of the tool call.
    AUTO_FEED = 154 "F AUTO",
    /// Feed per revolution.
    FEED_PER_REVOLUTION = 155 "FU",
    /// Feed per tooth.
    FEED_PER_TOOTH = 156 "FZ",
    /// Time of the move.
    FEED_TIME = 157 "FT",
    /// Length of the tool beyond that of its table.
    LENGTH_DIFFERENCE = 158 "DL",
    /// Radius of the tool beyond that of its table.
    RADIUS_DIFFERENCE = 159 "DR",
    /// Retraction along the tool axis.
    RETRACTION = 160 "MB",
    /// Axis of the tool: 0 to 2 for X to Z.
    TOOL_AXIS = 161 "",
    /// First factor or setting of a cycle that takes several lines.
    SETTING = 162 "",
}

/// Returns the spelling of an address.
pub fn written(address: u8) -> String {
    if address.is_ascii_uppercase() {
        return char::from(address).to_string();
    }
    WRITTEN.iter().find(|(code, _)| *code == address).map_or(String::new(), |(_, name)| name.to_string())
}
