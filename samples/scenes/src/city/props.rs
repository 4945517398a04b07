//! The list of props in streets, each a mesh of some hundreds of triangles.
//!
//! All stand on y = 0 and face +z. They extend at most 1.9 m from their middle along x and z, cars
//! 2.3 m along x and 0.95 m along z.

use scene::Mesh;

use super::palette::{Materials, TintKind};
use super::{furniture, plants, shelters, vehicles};

/// The places where a prop may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Site {
    /// Anywhere on a pavement, and in courts.
    Pavement,
    /// At the kerb, at regular intervals.
    Lamp,
    /// On the road at the kerb, parallel to it.
    Parking,
    /// In the middle of a court.
    Court,
}

/// One kind of prop.
pub(crate) struct Prop {
    pub(crate) mesh: Mesh,
    pub(crate) site: Site,
    pub(crate) tint: TintKind,
    /// The weight with which it is chosen among the props of its site.
    pub(crate) weight: u32,
}

/// Returns all kinds of props.
pub(crate) fn props(materials: &Materials) -> Vec<Prop> {
    let prop =
        |mesh: Mesh, site: Site, tint: TintKind, weight: u32| Prop { mesh, site, tint, weight };
    vec![
        prop(furniture::lamp(materials), Site::Lamp, TintKind::Furniture, 1),
        prop(plants::round_tree(materials), Site::Pavement, TintKind::Leaf, 13),
        prop(plants::tall_tree(materials), Site::Pavement, TintKind::Leaf, 7),
        prop(plants::spreading_tree(materials), Site::Pavement, TintKind::Leaf, 11),
        prop(plants::planter(materials), Site::Pavement, TintKind::Leaf, 4),
        prop(furniture::bench(materials), Site::Pavement, TintKind::Furniture, 6),
        prop(furniture::bin(materials), Site::Pavement, TintKind::Furniture, 4),
        prop(furniture::hydrant(), Site::Pavement, TintKind::Plain, 3),
        prop(furniture::post_box(materials), Site::Pavement, TintKind::Plain, 2),
        prop(furniture::bollards(materials), Site::Pavement, TintKind::Plain, 3),
        prop(furniture::bicycle_stand(materials), Site::Pavement, TintKind::Plain, 3),
        prop(shelters::advertising_column(materials), Site::Pavement, TintKind::Furniture, 2),
        prop(shelters::kiosk(materials), Site::Pavement, TintKind::Furniture, 2),
        prop(shelters::bus_stop(materials), Site::Pavement, TintKind::Plain, 2),
        prop(vehicles::saloon(materials), Site::Parking, TintKind::Vehicle, 5),
        prop(vehicles::hatchback(materials), Site::Parking, TintKind::Vehicle, 5),
        prop(vehicles::van(materials), Site::Parking, TintKind::Vehicle, 2),
        prop(shelters::fountain(materials), Site::Court, TintKind::Plain, 1),
    ]
}
