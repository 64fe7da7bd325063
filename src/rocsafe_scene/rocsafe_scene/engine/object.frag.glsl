// SPDX-License-Identifier: Apache-2.0
// Things: coloured vertices, dirt and wear from a tile, foliage with two sides.
in vec3 world;
in vec3 normal;
in vec4 tint;
in vec2 place;
uniform ivec4 meta;             // class, instance, 0, 0
uniform vec4 shift;             // of the dirt on this thing: no two alike
uniform sampler2D grain;        // fine, blotchy, streaked, rust
uniform vec4 looks[16];

void main() {
    int kind = int(tint.a * 255.0 + 0.5);
    vec4 look = looks[kind];
    vec3 n = normalize(normal);
    vec3 to_eye = p3d_ViewMatrixInverse[3].xyz - world;
    float range = length(to_eye);
    vec3 view = to_eye / range;
    if (look.w > 0.0 && dot(n, view) < -0.2) n = -n;
    vec4 dirt = texture(grain, place * 0.31 + shift.xy);
    vec3 albedo = tint.rgb * tint.rgb;
    float wear = 1.0 + look.z * (1.1 * (dirt.r - 0.5) + 1.3 * (dirt.g - 0.5) + 0.8 * (dirt.b - 0.5));
    if (kind == 2) albedo = mix(albedo, vec3(0.16, 0.065, 0.03), smoothstep(0.5, 0.78, dirt.a) * 0.85);
    if (kind == 1) albedo = mix(albedo, vec3(0.14, 0.09, 0.06), smoothstep(0.66, 0.9, dirt.a) * 0.5);
    albedo *= max(wear, 0.05) * (1.0 - 0.35 * air.y * step(0.5, 1.0 - look.x));
    look.x = min(1.0, look.x + 0.3 * air.y);
    float slope = 1.0 - max(dot(n, sun_direction), 0.0);
    vec3 colour = lit(albedo, n, view, look, shadow(world + 0.04 * n, slope), openness(world + n * 0.4));
    picture = vec4(seen(colour, range), 1.0);
    write_labels(meta.y, meta.x, n);
}
