// SPDX-License-Identifier: Apache-2.0
// Leaves and blades: many, small, lit from both sides; the short way.
in vec3 world;
in vec3 normal;
in vec4 tint;
in vec2 place;
in float depth;
in vec3 to_eye;
uniform ivec4 meta;             // class, instance, 0, 0

void main() {
    vec3 n = normalize(normal);
    float range = length(to_eye);
    float facing = dot(n, sun_direction);
    float direct = max(facing, 0.0) + 0.32 * max(0.35 - 0.65 * facing, 0.0);
    float share = one_shadow(world + 0.25 * sun_direction);
    float open_share = openness(world + vec3(0.0, 0.0, 0.6));
    vec3 albedo = tint.rgb * tint.rgb * (1.0 - 0.3 * air.y);
    vec3 ambient = mix(bounce, mix(horizon, zenith, 0.55) * 1.15, 0.5 + 0.5 * n.z) * open_share;
    vec3 colour = albedo * (sun_light * (direct * share) + ambient);
    float glint = max(dot(n, normalize(sun_direction + to_eye / range)), 0.0);
    glint *= glint; glint *= glint; glint *= glint;
    colour += sun_light * (0.018 * glint * share);
    picture = vec4(seen(colour, to_eye, range), 1.0);
    write_labels(depth, meta.y, meta.x, n);
}
