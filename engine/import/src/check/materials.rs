//! Checks of materials, textures, samplers, images, cameras and lights: indices, enumerated values,
//! and numbers.

use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type as LightType};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::validation::Checked;
use gltf::json::{Camera, Image, Index, Material, Root, Texture, texture};

use super::numbers::{finite, in_range};
use crate::element::Kind;
use crate::error::{At, Fault, Reason};
use crate::extensions::{lights, plain_source, webp_source};
use crate::verdict::Verdict;

pub(super) fn check(root: &Root, verdict: &mut Verdict) -> Result<(), Fault> {
    each(&root.materials, Kind::Material, verdict, |material| check_material(root, material))?;
    each(&root.textures, Kind::Texture, verdict, |texture| check_texture(root, texture))?;
    each(&root.samplers, Kind::Sampler, verdict, check_sampler)?;
    each(&root.images, Kind::Image, verdict, |image| check_image(root, image))?;
    each(&root.cameras, Kind::Camera, verdict, check_camera)?;
    each(lights(root), Kind::Light, verdict, check_light)
}

/// Judges each element of a list.
fn each<T>(
    list: &[T],
    kind: Kind,
    verdict: &mut Verdict,
    check: impl Fn(&T) -> Result<(), Reason>,
) -> Result<(), Fault> {
    for (index, element) in list.iter().enumerate() {
        let at = kind.at(index);
        verdict.judge(at, check(element).at(|| at.to_string()))?;
    }
    Ok(())
}

fn check_material(root: &Root, material: &Material) -> Result<(), Reason> {
    if material.alpha_mode == Checked::Invalid {
        return Err(Reason::malformed("its alphaMode does not exist"));
    }
    let metallic = &material.pbr_metallic_roughness;
    finite("baseColorFactor", &metallic.base_color_factor.0)?;
    finite("metallicFactor", &[metallic.metallic_factor.0])?;
    finite("roughnessFactor", &[metallic.roughness_factor.0])?;
    finite("emissiveFactor", &material.emissive_factor.0)?;
    finite("alphaCutoff", &[material.alpha_cutoff.map_or(0.0, |cutoff| cutoff.0)])?;
    let strength =
        material.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
    finite("emissiveStrength", &[strength.map_or(1.0, |strength| strength.emissive_strength.0)])?;

    let plain = [
        &metallic.base_color_texture,
        &metallic.metallic_roughness_texture,
        &material.emissive_texture,
    ];
    for info in plain.into_iter().flatten() {
        let transform =
            info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        check_use(root, info.index, transform)?;
    }
    if let Some(normal) = &material.normal_texture {
        finite("normalTexture scale", &[normal.scale])?;
        in_range("texture", normal.index.value(), root.textures.len())?;
    }
    if let Some(occlusion) = &material.occlusion_texture {
        finite("occlusionTexture strength", &[occlusion.strength.0])?;
        in_range("texture", occlusion.index.value(), root.textures.len())?;
    }
    Ok(())
}

fn check_use(
    root: &Root,
    texture: Index<Texture>,
    transform: Option<&TextureTransform>,
) -> Result<(), Reason> {
    in_range("texture", texture.value(), root.textures.len())?;
    let Some(transform) = transform else { return Ok(()) };
    finite("texture offset", &transform.offset.0)?;
    finite("texture rotation", &[transform.rotation.0])?;
    finite("texture scale", &transform.scale.0)
}

fn check_texture(root: &Root, texture: &Texture) -> Result<(), Reason> {
    if let Some(sampler) = texture.sampler {
        in_range("sampler", sampler.value(), root.samplers.len())?;
    }
    let plain = plain_source(texture);
    for image in plain.into_iter().chain(webp_source(texture)?) {
        in_range("image", image, root.images.len())?;
    }
    Ok(())
}

fn check_sampler(sampler: &texture::Sampler) -> Result<(), Reason> {
    let is_known = sampler.mag_filter != Some(Checked::Invalid)
        && sampler.min_filter != Some(Checked::Invalid)
        && sampler.wrap_s != Checked::Invalid
        && sampler.wrap_t != Checked::Invalid;
    if is_known {
        Ok(())
    } else {
        Err(Reason::malformed("its filter or wrapping mode does not exist"))
    }
}

fn check_image(root: &Root, image: &Image) -> Result<(), Reason> {
    match image.buffer_view {
        Some(view) => in_range("buffer view", view.value(), root.buffer_views.len()),
        None if image.uri.is_some() => Ok(()),
        None => Err(Reason::malformed("it has neither a URI nor a buffer view")),
    }
}

fn check_camera(camera: &Camera) -> Result<(), Reason> {
    match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(view), _) => finite(
            "projection",
            &[view.yfov, view.znear, view.zfar.unwrap_or(0.0), view.aspect_ratio.unwrap_or(0.0)],
        ),
        (Checked::Valid(CameraType::Orthographic), _, Some(view)) => {
            finite("projection", &[view.xmag, view.ymag, view.znear, view.zfar])
        }
        (Checked::Invalid, ..) => Err(Reason::malformed("its type does not exist")),
        _ => Err(Reason::malformed("it has no values for its type")),
    }
}

fn check_light(light: &Light) -> Result<(), Reason> {
    finite("color", &light.color)?;
    finite("intensity", &[light.intensity])?;
    finite("range", &[light.range.unwrap_or(0.0)])?;
    match (light.type_, &light.spot) {
        (Checked::Invalid, _) => Err(Reason::malformed("its type does not exist")),
        (Checked::Valid(LightType::Spot), None) => {
            Err(Reason::malformed("it is a spot light without a cone"))
        }
        (_, Some(spot)) => finite("cone", &[spot.inner_cone_angle, spot.outer_cone_angle]),
        (_, None) => Ok(()),
    }
}
