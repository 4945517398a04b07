// Moves a vertex onto the grid of sub-pixels, as the rasteriser will.
//
// A rasteriser snaps vertices to that grid before it looks which samples a triangle covers. Some
// (Google's SwiftShader, with 16 steps per pixel) still compute depth from the unsnapped vertices:
// a triangle seen edge-on then covers samples that are far outside of it, and carries a depth there
// that is nowhere on it. Tests that rely on the object's own depths would fail. Snapped here,
// vertices are the same in both steps.

// `steps` are those from the middle of the image to its edges.
vec4 snapped(vec4 clip, vec2 steps) {
    // Vertices outside of the near or far plane are cut off later; before the near plane they have
    // no place on the screen yet.
    return clip.w > 0.0 && clip.z >= 0.0 && clip.w >= clip.z ? vec4(round(clip.xy / clip.w * steps) / steps * clip.w, clip.zw) : clip;
}
