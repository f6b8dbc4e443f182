//! Minimal URDFs in a few words.

/// A link with these shapes and this mass.
pub(crate) fn link(name: &str, inside: &str) -> String {
    format!("<link name=\"{name}\">{inside}</link>\n")
}

/// A joint: its type, its parent and child, the child's place, and its axis.
pub(crate) fn joint(
    name: &str,
    kind: &str,
    [parent, child]: [&str; 2],
    origin: &str,
    axis: &str,
) -> String {
    let limit = match kind {
        "revolute" => "<limit lower=\"-0.6\" upper=\"0.6\" effort=\"1\" velocity=\"1\"/>",
        _ => "",
    };
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin {origin}/><axis \
         xyz=\"{axis}\"/>{limit}</joint>\n"
    )
}

/// A cylinder across the robot, beside its link by `y` (m).
pub(crate) fn cylinder(radius: f64, y: f64) -> String {
    format!(
        "<collision><origin xyz=\"0 {y} 0\" rpy=\"1.5708 0 0\"/><geometry><cylinder radius=\"{radius}\" \
         length=\"0.04\"/></geometry></collision>"
    )
}

/// A mesh, of which nothing is known.
pub(crate) const MESH: &str =
    "<visual><geometry><mesh filename=\"package://r/meshes/part.stl\"/></geometry></visual>";

/// The mass of a link that is a solid of this size.
pub(crate) fn mass(mass_kg: f64, inertia_kg_m2: f64) -> String {
    format!(
        "<inertial><mass value=\"{mass_kg}\"/><inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" \
         izz=\"{i}\"/></inertial>",
        i = inertia_kg_m2
    )
}

/// A wheel directly at the base: a link `NAME_link` and a joint NAME.
pub(crate) fn wheel(name: &str, xyz: &str, shape: &str) -> String {
    wheel_at("base_link", name, xyz, shape)
}

/// A wheel at another link.
pub(crate) fn wheel_at(parent: &str, name: &str, xyz: &str, shape: &str) -> String {
    let child = format!("{name}_link");
    let origin = format!("xyz=\"{xyz}\"");
    link(&child, shape) + &joint(name, "continuous", [parent, &child], &origin, "0 1 0")
}

/// A castor: a fork that turns about the vertical, and a wheel in it.
pub(crate) fn castor(fork: &str, wheel: &str, xyz: &str) -> String {
    let origin = format!("xyz=\"{xyz}\"");
    link(fork, "")
        + &joint(
            &format!("{fork}_joint"),
            "continuous",
            ["base_link", fork],
            &origin,
            "0 0 1",
        )
        + &wheel_at(fork, wheel, "-0.02 0 -0.03", &cylinder(0.03, 0.0))
}

/// A wheel that a joint with limits steers.
pub(crate) fn steered(name: &str, xyz: &str) -> String {
    let knuckle = format!("{name}_knuckle");
    let origin = format!("xyz=\"{xyz}\"");
    link(&knuckle, "")
        + &joint(
            &format!("{name}_turn"),
            "revolute",
            ["base_link", &knuckle],
            &origin,
            "0 0 1",
        )
        + &wheel_at(&knuckle, name, "0 0 0", &cylinder(0.1, 0.0))
}

/// The robot of these parts, with a base.
pub(crate) fn robot(parts: &[String]) -> String {
    format!(
        "<robot name=\"r\">\n{}{}</robot>\n",
        link("base_link", ""),
        parts.concat()
    )
}
