// SPDX-License-Identifier: Apache-2.0
// The sky, with clouds where the weather has them; number and class 0, infinitely far.
in vec3 world;
in vec3 normal;
uniform sampler2D grain;

void main() {
    vec3 d = normalize(world - p3d_ViewMatrixInverse[3].xyz);
    vec3 colour = sky(d);
    float sun = max(dot(d, sun_direction), 0.0);
    colour += sun_light * (pow(sun, 900.0) * 6.0 + pow(sun, 60.0) * 0.12);
    if (d.z > 0.01) {
        vec2 at = d.xy / (d.z + 0.12) * 0.045;
        float cloud = 0.6 * texture(grain, at).g + 0.4 * texture(grain, at * 3.1 + 0.3).g;
        float cover = smoothstep(0.5, 0.72, cloud) * smoothstep(0.01, 0.2, d.z) * air.w;
        colour = mix(colour, horizon * 1.25 + sun_light * 0.1, cover);
    }
    vec3 shown = colour * air.z * 0.5;
    shown = shown * (2.51 * shown + 0.03) / (shown * (2.43 * shown + 0.59) + 0.14);
    picture = vec4(sqrt(clamp(shown, 0.0, 1.0)), 1.0);
    write_labels(0, 0, vec3(0.0));
    depth_bits = as_bytes(0x7f800000u);
}
