//! Elements of a rotor as ROSS saves them, in SI.

use super::Note;
use super::fields::{Fields, Sign};
use bladeoff_text::document::{Collector, Entry, Value};
use std::ops::Range;

/// A shaft element, base or layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Name in the file.
    pub element: String,
    /// Byte range of the name.
    pub span: Range<usize>,
    /// Left node.
    pub node: usize,
    /// Length \[m\].
    pub length: f64,
    /// Outer and inner diameter at the left and at the right end \[m\].
    pub ends: [[f64; 2]; 2],
    pub material: Material,
    pub shear: Shear,
    /// Rayleigh factors on mass \[1/s\] and stiffness \[s\] of the element.
    pub damping: [f64; 2],
}

impl Beam {
    /// Whether the two ends have different diameters.
    pub fn is_tapered(&self) -> bool {
        self.ends[0] != self.ends[1]
    }

    /// Whether `next` continues this element as the same cylinder.
    pub fn continues_as(&self, next: &Self) -> bool {
        let like = |beam: &Self| (beam.length, beam.ends, beam.shear);
        like(self) == like(next)
            && self.material.is_like(&next.material)
            && !self.is_tapered()
            && next.node == self.node + 1
    }
}

/// Material of a shaft element.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub name: String,
    /// Young's modulus and shear modulus \[Pa\].
    pub moduli: [f64; 2],
    /// Density [kg/m3].
    pub density: f64,
}

impl Material {
    /// Poisson's ratio that gives the shear modulus.
    pub fn poisson_ratio(&self) -> f64 {
        self.moduli[0] / (2.0 * self.moduli[1]) - 1.0
    }

    /// Whether the values are equal, whatever the names.
    pub fn is_like(&self, other: &Self) -> bool {
        self.moduli == other.moduli && self.density == other.density
    }
}

/// Shear deformation of a shaft element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shear {
    Cowper,
    Hutchinson,
    None,
}

/// A disc, or a part of a coupling or gear with the same effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    pub element: String,
    pub span: Range<usize>,
    pub node: usize,
    pub mass: f64,
    /// Moment of inertia about a diameter [kg m2].
    pub transverse: f64,
    /// Moment of inertia about the axis [kg m2].
    pub polar: f64,
}

/// A bearing, seal or support spring.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    pub element: String,
    pub span: Range<usize>,
    pub node: usize,
    /// Node of the other side; `None`: ground.
    pub link: Option<usize>,
    /// Speeds of the table \[rad/s\]; at most one entry: constant coefficients.
    pub speeds: Vec<f64>,
    /// Stiffness xx, xy, yx, yy \[N/m\], each with one entry per speed.
    pub stiffness: [Vec<f64>; 4],
    /// Damping xx, xy, yx, yy \[N s/m\].
    pub damping: [Vec<f64>; 4],
    /// Axial stiffness \[N/m\].
    pub axial: f64,
}

/// A point mass.
#[derive(Debug, Clone, PartialEq)]
pub struct PointMass {
    pub element: String,
    pub span: Range<usize>,
    pub node: usize,
    /// Mass along X and Y \[kg\].
    pub mass: [f64; 2],
}

/// All elements of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rotor {
    pub version: Option<String>,
    /// Rated and largest speed \[rad/s\].
    pub rated: Option<f64>,
    pub largest: Option<f64>,
    pub beams: Vec<Beam>,
    pub discs: Vec<Disc>,
    pub bearings: Vec<Bearing>,
    pub masses: Vec<PointMass>,
    /// Whether a shaft element was invalid, which has been reported: the shaft has a gap there.
    pub gap: bool,
    /// Whether a bearing was invalid, which has been reported.
    pub lost_bearing: bool,
}

/// Largest number of bearings, of discs and of point masses; within each kind, all are compared with each other.
const MOST: usize = 500;

/// Tables that are not elements.
const NO_ELEMENTS: [&str; 3] = ["parameters", "ross_version", "_note"];

impl Rotor {
    /// Reads every element. Mistakes are reported; elements that a machine cannot have are noted.
    pub fn read(entries: &[Entry], problems: &mut Collector<'_>, notes: &mut Vec<Note>) -> Self {
        let mut rotor = Self::default();
        for entry in entries {
            match (&*entry.name, &entry.node.value) {
                ("ross_version", Value::Text(version)) => rotor.version = Some(version.clone()),
                ("parameters", Value::Table(_)) => {
                    let mut fields = Fields::new(entry, problems);
                    let mut speed = |name| if fields.has(name) { fields.number(name, Sign::NotNegative) } else { None };
                    (rotor.rated, rotor.largest) = (speed("rated_w"), speed("max_w"));
                }
                (name, _) if NO_ELEMENTS.contains(&name) => {}
                (_, Value::Table(_)) => rotor.element(Fields::new(entry, problems), notes),
                (name, other) => {
                    let message = format!("{} in the place of the table of an element is left out", other.type_name());
                    notes.push(Note::new(name, message));
                }
            }
        }
        let counts = [
            ("bearings and seals", rotor.bearings.len()),
            ("discs", rotor.discs.len()),
            ("point masses", rotor.masses.len()),
        ];
        for (kind, count) in counts.into_iter().filter(|(_, count)| *count > MOST) {
            problems.add(0..0, "", format!("{count} {kind}")).allowed = Some(format!("at most {MOST}"));
        }
        rotor.bearings.truncate(MOST);
        rotor.discs.truncate(MOST);
        rotor.masses.truncate(MOST);
        if rotor.beams.is_empty() && !rotor.gap {
            problems.add(0..0, "", "no shaft elements").allowed =
                Some("a rotor saved by ROSS, with tables named ShaftElement_TAG".to_owned());
        }
        rotor
    }

    fn element(&mut self, fields: Fields<'_, '_, '_>, notes: &mut Vec<Note>) {
        let class = fields.element.split('_').next().unwrap_or_default();
        let element = fields.element.to_owned();
        // classes by their beginning: earlier versions have ShaftElement6DoF and others
        if class.starts_with("ShaftElement") {
            match beam(fields, notes) {
                Some(beam) => self.beams.push(beam),
                None => self.gap = true,
            }
        } else if class.starts_with("PointMass") {
            self.masses.extend(point_mass(fields));
        } else if class.starts_with("Coupling") {
            coupling(fields);
            self.gap = true;
        } else if fields.has("kxx") {
            if class.starts_with("Magnetic") {
                notes.push(Note::new(
                    &element,
                    "the controller of a magnetic bearing is not converted: its coefficients are taken as they are",
                ));
            }
            match bearing(fields, notes) {
                Some(bearing) => self.bearings.push(bearing),
                None => self.lost_bearing = true,
            }
        } else if fields.has("Ip") && fields.has("Id") {
            if class.starts_with("Gear") {
                notes.push(Note::new(&element, "the mesh of a gear is not converted: it is a disc"));
            }
            self.discs.extend(disc(fields));
        } else {
            let message = match lacking(class) {
                Some(keys) => format!("an element without {keys} is left out"),
                None => "an element of an unknown class is left out".to_owned(),
            };
            notes.push(Note::new(&element, message));
        }
    }
}

/// A key that an element of a known class requires; `None`: an unknown class.
fn lacking(class: &str) -> Option<&'static str> {
    if ["Bearing", "Seal", "SqueezeFilm"].iter().any(|kind| class.contains(kind)) {
        Some("kxx")
    } else if ["Disk", "Gear"].iter().any(|kind| class.starts_with(kind)) {
        Some("Ip and Id")
    } else {
        None
    }
}

fn beam(mut fields: Fields<'_, '_, '_>, notes: &mut Vec<Note>) -> Option<Beam> {
    let (element, span) = (fields.element.to_owned(), fields.span.clone());
    let node = fields.node("n");
    let length = fields.number("L", Sign::Positive);
    let [idl, odl] =
        [("idl", Sign::NotNegative), ("odl", Sign::Positive)].map(|(name, sign)| fields.number(name, sign));
    let idr = if fields.has("idr") { fields.number("idr", Sign::NotNegative) } else { idl };
    let odr = if fields.has("odr") { fields.number("odr", Sign::Positive) } else { odl };
    for (inner, outer, name) in [(idl, odl, "idl"), (idr, odr, "idr")] {
        if let (Some(inner), Some(outer)) = (inner, outer)
            && inner >= outer
        {
            let name = if fields.has(name) { name } else { "odr" };
            fields.fail(
                name,
                format!("inner diameter {inner} m, outer diameter {outer} m"),
                "an inner diameter below the outer one",
            );
            return None;
        }
    }
    let shear_effects = fields.flag("shear_effects", true);
    let shear = match (shear_effects?, fields.text("shear_method_calc")) {
        (false, _) => Shear::None,
        (true, Some("hutchinson")) => Shear::Hutchinson,
        (true, Some("cowper") | None) => Shear::Cowper,
        (true, Some(_)) => {
            fields.fail("shear_method_calc", "an unknown shear coefficient", "cowper, hutchinson");
            return None;
        }
    };
    for (name, what) in [("axial_force", "an axial force"), ("torque", "a constant torque")] {
        if fields.number_or(name, Sign::Any, 0.0)? != 0.0 {
            notes.push(Note::new(&element, format!("{what} does not act on the bending stiffness: left out")));
        }
    }
    for (name, what) in [("rotary_inertia", "rotary inertia"), ("gyroscopic", "gyroscopic moment")] {
        if !fields.flag(name, true)? {
            notes.push(Note::new(&element, format!("{what} cannot be switched off: it is included")));
        }
    }
    let damping =
        [fields.number_or("alpha", Sign::NotNegative, 0.0)?, fields.number_or("beta", Sign::NotNegative, 0.0)?];
    let material = material(fields.table("material")?)?;
    let ends = [[odl?, idl?], [odr?, idr?]];
    Some(Beam { element, span, node: node?, length: length?, ends, material, shear, damping })
}

fn material(mut fields: Fields<'_, '_, '_>) -> Option<Material> {
    let [young, shear, density] = ["E", "G_s", "rho"].map(|name| fields.number(name, Sign::Positive));
    let material = Material {
        name: fields.text("name").unwrap_or("material").to_owned(),
        moduli: [young?, shear?],
        density: density?,
    };
    let ratio = material.poisson_ratio();
    if ratio <= -1.0 || ratio >= 0.5 {
        let message = format!("Poisson's ratio E/(2 G_s) - 1 is {ratio:.4}");
        fields.fail("G_s", message, "a ratio above -1 and below 0.5: G_s above E/3");
        return None;
    }
    Some(material)
}

fn disc(mut fields: Fields<'_, '_, '_>) -> Option<Disc> {
    let node = fields.node("n");
    let [mass, transverse, polar] = ["m", "Id", "Ip"].map(|name| fields.number(name, Sign::NotNegative));
    let (element, span) = (fields.element.to_owned(), fields.span.clone());
    Some(Disc { element, span, node: node?, mass: mass?, transverse: transverse?, polar: polar? })
}

fn point_mass(mut fields: Fields<'_, '_, '_>) -> Option<PointMass> {
    let node = fields.node("n");
    let mass = if fields.has("mx") || fields.has("my") {
        ["mx", "my"].map(|name| fields.number_or(name, Sign::NotNegative, 0.0))
    } else {
        [fields.number("m", Sign::NotNegative); 2]
    };
    let (element, span) = (fields.element.to_owned(), fields.span.clone());
    Some(PointMass { element, span, node: node?, mass: [mass[0]?, mass[1]?] })
}

/// A coupling is an error: without it, the result would be another rotor.
fn coupling(mut fields: Fields<'_, '_, '_>) {
    fields.fail(
        "n",
        "a coupling between two shafts is not available",
        "one shaft per file, or a ShaftElement of the same length and stiffness in its place",
    );
}

const NAMES: [[&str; 4]; 3] =
    [["kxx", "kxy", "kyx", "kyy"], ["cxx", "cxy", "cyx", "cyy"], ["mxx", "mxy", "myx", "myy"]];

fn bearing(mut fields: Fields<'_, '_, '_>, notes: &mut Vec<Note>) -> Option<Bearing> {
    let (element, span) = (fields.element.to_owned(), fields.span.clone());
    let node = fields.node("n");
    let link = if fields.has("n_link") { Some(fields.node("n_link")?) } else { None };
    // the name depends on class and version
    let name = ["frequency", "speed", "omega"].into_iter().find(|name| fields.has(name)).unwrap_or("frequency");
    let speeds = fields.list(name, Sign::NotNegative);
    let lists = NAMES.map(|names| names.map(|name| fields.list(name, Sign::Any)));
    let axial = [fields.list("kzz", Sign::Any), fields.list("czz", Sign::Any)];
    let (node, speeds) = (node?, speeds?);
    if speeds.windows(2).any(|pair| pair[1] <= pair[0]) {
        fields.fail(name, "speeds that do not ascend", "each speed above the one before");
        return None;
    }
    let count = speeds.len().max(1);
    let mut whole = |name: &str, list: Option<Vec<f64>>, absent: &[f64]| {
        let list = list?;
        match list.len() {
            0 => {
                if fields.has(name) {
                    let taken = if absent.iter().all(|value| *value == 0.0) { "0 is" } else { "the xx coefficient is" };
                    notes.push(Note::new(&element, format!("{name} has no value: {taken} taken")));
                }
                Some(absent.to_vec())
            }
            1 => {
                if count > 1 {
                    notes.push(Note::new(&element, format!("{name} has one value: it is taken at all {count} speeds")));
                }
                Some(vec![list[0]; count])
            }
            length if length == count => Some(list),
            length => {
                let message = format!("{length} coefficients and {count} speeds");
                fields.fail(name, message, "as many coefficients as speeds");
                None
            }
        }
    };
    let [stiffness, damping, mass] = [0, 1, 2].map(|kind| {
        let [xx, xy, yx, yy] = [0, 1, 2, 3].map(|i| lists[kind][i].clone());
        let zero = vec![0.0; count];
        let xx = whole(NAMES[kind][0], xx, &zero)?;
        let [xy, yx] = [whole(NAMES[kind][1], xy, &zero)?, whole(NAMES[kind][2], yx, &zero)?];
        // as in ROSS: an absent yy is xx
        let yy = whole(NAMES[kind][3], yy, &xx)?;
        Some([xx, xy, yx, yy])
    });
    let [axial, axial_damping] = axial;
    let (axial, axial_damping) = (whole("kzz", axial, &[0.0])?, whole("czz", axial_damping, &[0.0])?);
    let (stiffness, damping, mass) = (stiffness?, damping?, mass?);
    if mass.iter().flatten().any(|mass| *mass != 0.0) {
        notes.push(Note::new(&element, "added mass (mxx and others) is left out: bearings have stiffness and damping"));
    }
    if axial_damping.iter().any(|damping| *damping != 0.0) {
        notes.push(Note::new(&element, "axial damping czz is left out: axial motion is not computed in time"));
    }
    if axial.iter().any(|stiffness| *stiffness != axial[0]) {
        notes.push(Note::new(
            &element,
            "axial stiffness kzz does not depend on the speed: the value at the lowest speed is taken",
        ));
    }
    if axial[0] < 0.0 {
        fields.fail("kzz", "negative axial stiffness", "a number >= 0");
        return None;
    }
    Some(Bearing { element, span, node, link, speeds, stiffness, damping, axial: axial[0] })
}
