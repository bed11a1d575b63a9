//! The cutting job as a file: stock, tools, material and limits; units in the key names.
//!
//! ```toml
//! material = "al7075"                  # or [coefficients], or both: these then replace single values
//! resolution_mm = 0.1                  # side of a cell of the stock; chosen by the tools when left out
//! spindle_rpm = 8000                   # where the program sets no speed
//! [stock]
//! min_mm = [0, 0, -20]
//! max_mm = [100, 60, 0]
//! [tool]                               # where [tools.N] has no row for the program's T number
//! diameter_mm = 12
//! teeth = 2
//! helix_deg = 30
//! max_force_n = 800                    # also max_torque_nm, max_power_w, max_chip_mm, and
//! overhang_mm = 40                     # with these, how far it is bent
//! max_deflection_mm = 0.05             # modulus_gpa = 600 where left out: carbide
//! [spindle]
//! max_power_w = 15000
//! ```
//!
//! Invalid text is a fault; the computation of forces reports missing data.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::cutting::{
    Coefficients, LoadLimits, MATERIALS, Material, Mill, Setup, StockBox, compliance, material,
};
use crate::machine::Machine;
use crate::project::TextFault;
use crate::project::machine::file::place;
use crate::units::{n_mm_of_n_m, n_mm_per_s_of_watts, n_per_mm2_of_gpa};

/// An example of a cutting job.
pub const EXAMPLE_CUTTING: &str = "\
material = \"al7075\"      # al6061, al6082, ti6al4v, c45; or [coefficients]

[stock]                    # in the program's coordinates
min_mm = [-50, -50, -20]
max_mm = [50, 50, 0]

[tool]                     # or [tools.1], by T number
diameter_mm = 10
teeth = 2
helix_deg = 30
max_force_n = 800          # also max_torque_nm, max_power_w, max_chip_mm; corner_radius_mm, runout_mm
overhang_mm = 35           # out of the holder; bends, as carbide unless modulus_gpa says otherwise
max_deflection_mm = 0.05

[spindle]
max_power_w = 10000        # also max_torque_nm
";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CuttingFile {
    material: Option<String>,
    resolution_mm: Option<f64>,
    spindle_rpm: Option<f64>,
    stock: Option<StockTable>,
    tool: Option<MillTable>,
    #[serde(default)]
    tools: BTreeMap<String, MillTable>,
    spindle: Option<SpindleTable>,
    coefficients: Option<CoefficientTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StockTable {
    min_mm: [f64; 3],
    max_mm: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MillTable {
    diameter_mm: Option<f64>,
    teeth: Option<u32>,
    helix_deg: Option<f64>,
    corner_radius_mm: Option<f64>,
    runout_mm: Option<f64>,
    max_force_n: Option<f64>,
    max_torque_nm: Option<f64>,
    max_power_w: Option<f64>,
    max_chip_mm: Option<f64>,
    overhang_mm: Option<f64>,
    modulus_gpa: Option<f64>,
    max_deflection_mm: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpindleTable {
    max_torque_nm: Option<f64>,
    max_power_w: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CoefficientTable {
    ktc_n_mm2: Option<f64>,
    krc_n_mm2: Option<f64>,
    kac_n_mm2: Option<f64>,
    kte_n_mm: Option<f64>,
    kre_n_mm: Option<f64>,
    kae_n_mm: Option<f64>,
}

/// Reads a cutting job. Missing diameters are taken from the machine's tool table.
///
/// # Errors
///
/// Returns the first fault of the text.
pub fn cutting_from_toml(text: &str, machine: &Machine) -> Result<Setup, TextFault> {
    let file: CuttingFile = toml::from_str(text).map_err(|error| TextFault {
        place: error.span().map(|span| place(text, span.start)),
        key: None,
        message: error.message().replace('\n', " "),
    })?;
    let stock = file.stock.map(stock).transpose()?;
    let mut tools = BTreeMap::new();
    for (name, table) in file.tools {
        let key = format!("tools.{name}");
        let number: u32 = name
            .parse()
            .map_err(|_| TextFault::at_key(&key, format!("{name} is not a tool number such as 5")))?;
        let of_machine = machine.tools.get(&number).map(|tool| tool.diameter);
        tools.insert(number, mill(table, of_machine, &key)?);
    }
    let spindle = file.spindle.unwrap_or(SpindleTable { max_torque_nm: None, max_power_w: None });
    let (coefficients, material) = coefficients(file.material.as_deref(), file.coefficients)?;
    Ok(Setup {
        stock,
        resolution: within("resolution_mm", file.resolution_mm, 1e-3..=100.0, "mm")?,
        coefficients,
        material,
        tool: file.tool.map(|table| mill(table, None, "tool")).transpose()?,
        tools,
        spindle_speed: within("spindle_rpm", file.spindle_rpm, 1.0..=1e6, "rpm")?,
        spindle: limits("spindle", None, spindle.max_torque_nm, spindle.max_power_w)?,
    })
}

fn stock(table: StockTable) -> Result<StockBox, TextFault> {
    for (key, corner) in [("stock.min_mm", table.min_mm), ("stock.max_mm", table.max_mm)] {
        for value in corner {
            within(key, Some(value), -1e5..=1e5, "mm")?;
        }
    }
    Ok(StockBox { min: table.min_mm, max: table.max_mm })
}

/// Young's modulus of carbide, GPa.
const CARBIDE_GPA: f64 = 600.0;

/// Reads a tool; `diameter` replaces a missing diameter.
fn mill(table: MillTable, diameter: Option<f64>, key: &str) -> Result<Mill, TextFault> {
    let checked = |name: &str, value: Option<f64>, range: RangeInclusive<f64>, unit: &str| {
        within(&format!("{key}.{name}"), value, range, unit)
    };
    let diameter = checked("diameter_mm", table.diameter_mm, 1e-3..=1000.0, "mm")?.or(diameter);
    let radius = 0.5 * diameter.unwrap_or(1000.0);
    let overhang = checked("overhang_mm", table.overhang_mm, 0.0..=1000.0, "mm")?;
    let modulus = checked("modulus_gpa", table.modulus_gpa, 1.0..=2000.0, "GPa")?.unwrap_or(CARBIDE_GPA);
    let deflection = checked("max_deflection_mm", table.max_deflection_mm, 0.0..=10.0, "mm")?;
    if deflection.is_some() && overhang.is_none() {
        let key = format!("{key}.overhang_mm");
        return Err(TextFault::at_key(
            &key,
            "this key is missing, and max_deflection_mm needs it".to_string(),
        ));
    }
    let chip = checked("max_chip_mm", table.max_chip_mm, 0.0..=10.0, "mm")?;
    let bends = diameter.zip(overhang);
    checked("teeth", table.teeth.map(f64::from), 1.0..=100.0, "")?;
    Ok(Mill {
        diameter,
        corner_radius: checked("corner_radius_mm", table.corner_radius_mm, 0.0..=radius, "mm")?
            .unwrap_or(0.0),
        teeth: table.teeth,
        helix: checked("helix_deg", table.helix_deg, -75.0..=75.0, "°")?.unwrap_or(0.0).to_radians(),
        runout: checked("runout_mm", table.runout_mm, 0.0..=1.0, "mm")?.unwrap_or(0.0),
        compliance: bends
            .map_or(0.0, |(diameter, overhang)| compliance(diameter, overhang, n_per_mm2_of_gpa(modulus))),
        limits: LoadLimits {
            chip: chip.unwrap_or(f64::INFINITY),
            deflection: deflection.unwrap_or(f64::INFINITY),
            ..limits(key, table.max_force_n, table.max_torque_nm, table.max_power_w)?
        },
    })
}

fn limits(
    key: &str,
    force: Option<f64>,
    torque_nm: Option<f64>,
    power_w: Option<f64>,
) -> Result<LoadLimits, TextFault> {
    let checked =
        |name: &str, value: Option<f64>, unit: &str| within(&format!("{key}.{name}"), value, 0.0..=1e7, unit);
    let or_none = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    Ok(LoadLimits {
        force: or_none(checked("max_force_n", force, "N")?),
        torque: or_none(checked("max_torque_nm", torque_nm, "N·m")?.map(n_mm_of_n_m)),
        power: or_none(checked("max_power_w", power_w, "W")?.map(n_mm_per_s_of_watts)),
        ..LoadLimits::default()
    })
}

/// Returns the coefficients of a material with single values replaced, and the material if none is replaced;
/// without a material, all coefficients must be given, or none.
fn coefficients(
    word: Option<&str>,
    table: Option<CoefficientTable>,
) -> Result<(Option<Coefficients>, Option<&'static Material>), TextFault> {
    let named = match word {
        Some(word) => {
            let known = material(word).ok_or_else(|| {
                let words = MATERIALS.map(|material| material.word).join(", ");
                TextFault::at_key("material", format!("{word} is not known; expected one of: {words}"))
            })?;
            Some(known)
        }
        None => None,
    };
    let Some(table) = table else { return Ok((named.map(|named| named.coefficients), named)) };
    let value = |name: &str, given: Option<f64>, known: Option<f64>| {
        let key = format!("coefficients.{name}");
        within(&key, given, 0.0..=1e5, "")?.or(known).ok_or_else(|| {
            TextFault::at_key(&key, "this key is missing, and no material is given".to_string())
        })
    };
    let known = |of: fn(&Coefficients) -> f64| named.map(|named| of(&named.coefficients));
    let own = Coefficients {
        cutting: [
            value("ktc_n_mm2", table.ktc_n_mm2, known(|named| named.cutting[0]))?,
            value("krc_n_mm2", table.krc_n_mm2, known(|named| named.cutting[1]))?,
            value("kac_n_mm2", table.kac_n_mm2, known(|named| named.cutting[2]))?,
        ],
        edge: [
            value("kte_n_mm", table.kte_n_mm, known(|named| named.edge[0]))?,
            value("kre_n_mm", table.kre_n_mm, known(|named| named.edge[1]))?,
            value("kae_n_mm", table.kae_n_mm, known(|named| named.edge[2]))?,
        ],
    };
    Ok((Some(own), named.filter(|named| named.coefficients == own)))
}

fn within(
    key: &str,
    value: Option<f64>,
    range: RangeInclusive<f64>,
    unit: &str,
) -> Result<Option<f64>, TextFault> {
    match value {
        Some(value) if !range.contains(&value) => {
            let message = format!("{value} is outside {} to {} {unit}", range.start(), range.end());
            Err(TextFault::at_key(key, message.trim_end().to_string()))
        }
        _ => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Tool;

    const JOB: &str = "material = \"al7075\"\n[stock]\nmin_mm = [0, 0, -20]\nmax_mm = [100, 60, 0]\n\
        [tool]\ndiameter_mm = 12\nteeth = 2\nhelix_deg = 30\nmax_torque_nm = 4\n[tools.7]\nteeth = 4\n\
        [spindle]\nmax_power_w = 15000\n";

    fn read(text: &str) -> Result<Setup, String> {
        cutting_from_toml(text, &Machine::default()).map_err(|fault| fault.to_string())
    }

    #[test]
    fn a_job_is_read_in_core_units() {
        let setup = read(JOB).expect("right");
        let tool = setup.tool.expect("given");
        assert_eq!((tool.diameter, tool.teeth, tool.limits.torque), (Some(12.0), Some(2), 4000.0));
        assert!((tool.helix - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
        assert_eq!(setup.spindle.power, 15e6);
        assert_eq!(setup.coefficients, Some(material("al7075").expect("known").coefficients));
        assert_eq!(setup.stock.expect("given").max, [100.0, 60.0, 0.0]);
        assert_eq!(read(""), Ok(Setup::default()));
        let example = read(EXAMPLE_CUTTING).expect("right");
        assert!(example.stock.is_some() && example.tool.is_some() && example.coefficients.is_some());
    }

    #[test]
    fn a_diameter_left_out_is_the_machines() {
        let tools = [(7, Tool { diameter: 8.0 })].into();
        let machine = Machine { tools, ..Machine::default() };
        assert_eq!(cutting_from_toml(JOB, &machine).expect("right").tools[&7].diameter, Some(8.0));
        assert_eq!(read(JOB).expect("right").tools[&7].diameter, None);
    }

    #[test]
    fn single_coefficients_replace_those_of_the_material() {
        let setup = read(&format!("{JOB}[coefficients]\nkte_n_mm = 20\n")).expect("right");
        let found = setup.coefficients.expect("given");
        assert_eq!((found.edge[0], found.cutting[0]), (20.0, 767.01));
    }

    #[test]
    fn faults_say_where_and_what() {
        let fault = |text: &str| read(text).expect_err("wrong");
        assert!(
            fault("[tool]\nteth = 2").starts_with("line 2, column 1: unknown field `teth`, expected one of")
        );
        assert_eq!(fault("[tool]\nteeth = 0"), "tool.teeth: 0 is outside 1 to 100");
        assert_eq!(fault("[tools.x]\nteeth = 2"), "tools.x: x is not a tool number such as 5");
        assert_eq!(
            fault("[tool]\ndiameter_mm = 6\ncorner_radius_mm = 4"),
            "tool.corner_radius_mm: 4 is outside 0 to 3 mm"
        );
        assert!(fault("material = \"wood\"").contains("expected one of: al7075, "));
        assert!(
            fault("[coefficients]\nktc_n_mm2 = 700")
                .starts_with("coefficients.krc_n_mm2: this key is missing")
        );
        assert!(fault("resolution_mm = nan").contains("NaN is outside"));
        assert!(fault("[stock]\nmin_mm = [0, 0]\nmax_mm = [1, 1, 1]").starts_with("line 2, column 10: "));
    }
}
