//! Coefficients of the linear edge force model for common materials.
//!
//! ```text
//! dF_t = (K_tc h + K_te) dz    tangential, against the motion of the tooth
//! dF_r = (K_rc h + K_re) dz    radial, towards the axis of the tool
//! dF_a = (K_ac h + K_ae) dz    axial
//! ```
//!
//! h chip thickness (mm), dz height of an element of the edge (mm), K_c cutting coefficients
//! (N/mm²), K_e edge coefficients (N/mm). They belong to a pair of tool and material: rake, edge
//! radius, wear and coating change them by tens of percent, so a measured set should replace them.
//!
//! The review quoted below prints the unit of edge coefficients as N·mm; by the model it is N/mm.
//!
//! Source of the model: Altintas, Manufacturing Automation, 2nd ed. 2012, Sect. 2.7. Each row has the source
//! of its numbers; if `is_checked` is `false`, the source was not available for comparison.

/// Coefficients of the linear edge force model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// K_tc, K_rc, K_ac, N/mm².
    pub cutting: [f64; 3],
    /// K_te, K_re, K_ae, N/mm.
    pub edge: [f64; 3],
}

/// A material with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Keyword that selects it.
    pub word: &'static str,
    /// Name.
    pub name: &'static str,
    /// Coefficients of the material.
    pub coefficients: Coefficients,
    /// Publication, with the tool that was used.
    pub source: &'static str,
    /// `true` if the numbers were compared with the source.
    pub is_checked: bool,
}

/// Returns a row of the review's table, which names each row by the work that it quotes; carbide unless
/// stated.
macro_rules! review {
    ($work:literal) => {
        concat!(
            "Duan et al., Milling Force Model for Aviation Aluminum Alloy, Chin. J. Mech. Eng. 34:18 (2021), \
             doi 10.1186/s10033-021-00536-9, Table 5, row [",
            $work,
            "]"
        )
    };
}

const fn row(
    word: &'static str,
    name: &'static str,
    cutting: [f64; 3],
    edge: [f64; 3],
    source: &'static str,
    is_checked: bool,
) -> Material {
    Material { word, name, coefficients: Coefficients { cutting, edge }, source, is_checked }
}

/// The materials by keyword; the first is the paper's.
pub const MATERIALS: [Material; 6] = [
    row("al7075", "aluminium 7075-T6", [767.01, 168.8, 222.0], [27.7, 26.6, 0.7], review!("190"), true),
    row(
        "al7075-sharp",
        "aluminium 7075-T6, another set; axial coefficients not published, taken as 0",
        [600.46, 180.96, 0.0],
        [17.9, 20.42, 0.0],
        review!("160"),
        true,
    ),
    row(
        "al6061",
        "aluminium 6061-T6; axial coefficients not published, taken as 0",
        [243.77, 113.5, 0.0],
        [7.53, 7.83, 0.0],
        review!("160"),
        true,
    ),
    row("al6082", "aluminium 6082-T6", [631.0, 99.0, 273.0], [13.0, 10.0, 2.8], review!("189"), true),
    row(
        "ti6al4v",
        "titanium Ti-6Al-4V",
        [1825.0, 770.0, 735.0],
        [29.7, 55.7, 1.8],
        "attributed to Altintas, Manufacturing Automation; unchecked, replace with measured values",
        false,
    ),
    row(
        "c45",
        "carbon steel C45, AISI 1045",
        [2640.0, 1060.0, 0.0],
        [43.0, 17.0, 0.0],
        "tangent at h = 0.1 mm to Kienzle's law with k_c1.1 = 2220 N/mm² and m_c = 0.14, radial force 0.4 of the \
         tangential; a rule of thumb, unchecked, replace with measured values",
        false,
    ),
];

/// Returns the material of a keyword; `None` if it is unknown.
pub fn material(word: &str) -> Option<&'static Material> {
    MATERIALS.iter().find(|material| material.word == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_unique_and_every_row_says_where_it_is_from() {
        for (index, row) in MATERIALS.iter().enumerate() {
            assert_eq!(MATERIALS.iter().position(|other| other.word == row.word), Some(index));
            assert!(!row.source.is_empty() && 0.0 < row.coefficients.cutting[0]);
            assert_ne!(row.is_checked, row.source.contains("unchecked"), "{}", row.word);
        }
    }

    /// The tangent at h = 0.1 mm of k h^(1 − m).
    #[test]
    fn the_steel_is_the_tangent_to_its_law() {
        let (k, m, h) = (2220.0, 0.14, 0.1_f64);
        let slope = (1.0 - m) * k * h.powf(-m);
        let Coefficients { cutting, edge } = material("c45").expect("known").coefficients;
        assert!((slope / cutting[0] - 1.0).abs() < 0.01, "{slope}");
        assert!((edge[0] + cutting[0] * h - k * h.powf(1.0 - m)).abs() < 1.0);
    }
}
