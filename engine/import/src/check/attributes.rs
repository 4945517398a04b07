//! Checks of the types of primitives' attributes (glTF 2.0, section 3.7.2;
//! `KHR_mesh_quantization`).

use gltf::Semantic;
use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use crate::error::Reason;

/// A component type, and true if it is normalised.
type Form = (ComponentType, bool);

const FLOAT: Form = (ComponentType::F32, false);
const U8: Form = (ComponentType::U8, false);
const U16: Form = (ComponentType::U16, false);
const I8: Form = (ComponentType::I8, false);
const I16: Form = (ComponentType::I16, false);
const UNORM8: Form = (ComponentType::U8, true);
const UNORM16: Form = (ComponentType::U16, true);
const SNORM8: Form = (ComponentType::I8, true);
const SNORM16: Form = (ComponentType::I16, true);

/// The types allowed for an attribute.
pub(super) struct Allowed {
    kinds: &'static [Type],
    forms: &'static [Form],
    /// The additional types that `KHR_mesh_quantization` allows.
    quantised: &'static [Form],
}

const fn of(kinds: &'static [Type], forms: &'static [Form], quantised: &'static [Form]) -> Allowed {
    Allowed { kinds, forms, quantised }
}

const POSITION: Allowed =
    of(&[Type::Vec3], &[FLOAT], &[I8, SNORM8, U8, UNORM8, I16, SNORM16, U16, UNORM16]);
const NORMAL: Allowed = of(&[Type::Vec3], &[FLOAT], &[SNORM8, SNORM16]);
const TANGENT: Allowed = of(&[Type::Vec4], &[FLOAT], &[SNORM8, SNORM16]);
const TEXCOORD: Allowed =
    of(&[Type::Vec2], &[FLOAT, UNORM8, UNORM16], &[U8, I8, SNORM8, U16, I16, SNORM16]);
const COLOR: Allowed = of(&[Type::Vec3, Type::Vec4], &[FLOAT, UNORM8, UNORM16], &[]);
const JOINTS: Allowed = of(&[Type::Vec4], &[U8, U16], &[]);
const WEIGHTS: Allowed = of(&[Type::Vec4], &[FLOAT, UNORM8, UNORM16], &[]);
pub(super) const POSITION_DELTA: Allowed = of(&[Type::Vec3], &[FLOAT], &[I8, SNORM8, I16, SNORM16]);
/// The types of a morph target's displacements of normals or tangents.
pub(super) const DIRECTION_DELTA: Allowed = of(&[Type::Vec3], &[FLOAT], &[SNORM8, SNORM16]);

/// Returns the types allowed for a vertex attribute; `None` for attributes of applications.
pub(super) fn allowed(semantic: &Semantic) -> Option<Allowed> {
    Some(match semantic {
        Semantic::Positions => POSITION,
        Semantic::Normals => NORMAL,
        Semantic::Tangents => TANGENT,
        Semantic::TexCoords(_) => TEXCOORD,
        Semantic::Colors(_) => COLOR,
        Semantic::Joints(_) => JOINTS,
        Semantic::Weights(_) => WEIGHTS,
        Semantic::Extras(_) => return None,
    })
}

/// Checks that an accessor has one of these types.
pub(super) fn check_form(
    accessor: &Accessor,
    kind: Type,
    forms: &'static [Form],
) -> Result<(), Reason> {
    let kinds: &[Type] = match kind {
        Type::Scalar => &[Type::Scalar],
        Type::Vec3 => &[Type::Vec3],
        Type::Vec4 => &[Type::Vec4],
        Type::Mat4 => &[Type::Mat4],
        Type::Vec2 | Type::Mat2 | Type::Mat3 => &[],
    };
    matches(accessor, kinds, forms.iter(), "")
}

/// The types of attributes that must be floats.
pub(super) const FLOATS: &[Form] = &[FLOAT];
/// The types of attributes that are floats or normalised integers.
pub(super) const FRACTIONS: &[Form] = &[FLOAT, SNORM8, UNORM8, SNORM16, UNORM16];
/// The types of indices.
pub(super) const INDICES: &[Form] = &[U8, U16, (ComponentType::U32, false)];

impl Allowed {
    /// Checks the type of an accessor.
    pub(super) fn check(&self, accessor: &Accessor, quantised: bool) -> Result<(), Reason> {
        let forms = self.forms.iter();
        if quantised {
            return matches(accessor, self.kinds, forms.chain(self.quantised), "");
        }
        let hint = if self.quantised.is_empty() { "" } else { " without KHR_mesh_quantization" };
        matches(accessor, self.kinds, forms, hint)
    }
}

fn matches<'a>(
    accessor: &Accessor,
    kinds: &[Type],
    mut forms: impl Iterator<Item = &'a Form>,
    hint: &str,
) -> Result<(), Reason> {
    let (Checked::Valid(kind), Checked::Valid(component)) =
        (accessor.type_, accessor.component_type)
    else {
        return Err(Reason::malformed("its type does not exist"));
    };
    let component = component.0;
    let is_normalised = accessor.normalized;
    let fits = kinds.contains(&kind)
        && forms.any(|&(allowed, normalised)| {
            // The flag has no meaning for floats.
            allowed == component && (normalised == is_normalised || component == ComponentType::F32)
        });
    if fits {
        return Ok(());
    }
    let elements = shown(kind, component, is_normalised);
    Err(Reason::malformed(format!("its elements may not be {elements}{hint}")))
}

/// Returns a description of an accessor's elements, such as "vectors of 3 floats".
fn shown(kind: Type, component: ComponentType, is_normalised: bool) -> String {
    let normalised = if is_normalised { "normalised " } else { "" };
    let numbers = match component {
        ComponentType::I8 => "signed 8-bit integers",
        ComponentType::U8 => "unsigned 8-bit integers",
        ComponentType::I16 => "signed 16-bit integers",
        ComponentType::U16 => "unsigned 16-bit integers",
        ComponentType::U32 => "unsigned 32-bit integers",
        ComponentType::F32 => "floats",
    };
    match kind {
        Type::Scalar => format!("{normalised}{numbers}"),
        Type::Vec2 => format!("vectors of 2 {normalised}{numbers}"),
        Type::Vec3 => format!("vectors of 3 {normalised}{numbers}"),
        Type::Vec4 => format!("vectors of 4 {normalised}{numbers}"),
        Type::Mat2 => format!("2 x 2 matrices of {normalised}{numbers}"),
        Type::Mat3 => format!("3 x 3 matrices of {normalised}{numbers}"),
        Type::Mat4 => format!("4 x 4 matrices of {normalised}{numbers}"),
    }
}
