// Khronos PBR Neutral tone mapping: colours that a display has stay what they are, save for the 4 %
// that a dielectric's surface adds; brighter ones are compressed and lose their saturation.

vec3 tone_mapped(vec3 light) {
    const float compressed_from = 0.8 - 0.04;
    const float desaturation = 0.15;
    float least = min(light.r, min(light.g, light.b));
    float toe = least < 0.08 ? least - 6.25 * least * least : 0.04;
    vec3 colour = light - toe;
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak < compressed_from) return colour;
    const float room = 1.0 - compressed_from;
    float compressed = 1.0 - room * room / (peak + room - compressed_from);
    float white = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(colour * (compressed / peak), vec3(compressed), white);
}
