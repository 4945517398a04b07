// Moves a vertex to where the rasteriser will: onto the grid of sub-pixels.
//
// A rasteriser snaps vertices to that grid before it looks which samples a triangle covers. Some (Google's
// SwiftShader, with 16 steps a pixel) go on to compute depth from where the vertices were before: a
// triangle seen edge-on then covers samples that are far outside of it, and carries a depth there
// that is nowhere on it. Nothing that rests on depths being those of the object would hold. Snapped
// here, vertices are the same in both steps.

// `steps` are those from the middle of the picture to its edges.
vec4 snapped(vec4 clip, vec2 steps) {
    // What is not before the near plane is cut off later, and has no place on the screen yet.
    return clip.w > 0.0 && clip.w >= clip.z ? vec4(round(clip.xy / clip.w * steps) / steps * clip.w, clip.zw) : clip;
}
