// SPDX-License-Identifier: Apache-2.0
// The ground: a picture of its own everywhere, the grain of a tile in it, water and wet places.
in vec3 world;
in vec3 normal;
uniform ivec4 meta;             // 0, instance, class of water, class of asphalt
uniform sampler2D ground;
uniform sampler2D classes;
uniform vec4 ground_area;       // west, south, 1 / width, 1 / height
uniform sampler2D grain;
#ifdef INNER
uniform sampler2D sunlit;       // shares of sun and sky that reach the ground
#endif

void main() {
    vec2 at = (world.xy - ground_area.xy) * ground_area.zw;
    vec3 albedo = texture(ground, at).rgb;
    int kind = int(textureLod(classes, at, 0.0).r * 255.0 + 0.5);
    vec3 to_eye = p3d_ViewMatrixInverse[3].xyz - world;
    float range = length(to_eye);
#ifdef DISTANT
    // What the tile comes to on the whole.
    vec4 tile = vec4(0.5);
#else
    vec4 tile = texture(grain, world.xy * 0.83);
#endif
    float light = dot(albedo, vec3(0.3, 0.6, 0.1));
    albedo *= albedo * (0.72 + 0.38 * tile.r + 0.18 * tile.b);
    vec3 n = normalize(normal);
    vec3 flat_normal = n;
    vec4 look = vec4(0.02, 8.0, 0.0, 0.0);
    // Bumps from the picture itself: bright is high.
    vec3 across = dFdx(world), along = dFdy(world);
    float rise_x = dFdx(light), rise_y = dFdy(light);
    vec3 bump = cross(along, n) * rise_x + cross(n, across) * rise_y;
    float area = dot(n, cross(across, along));
    n = normalize(n - sign(area) * bump / max(abs(area), 1e-6) * 0.05);
#ifdef WET
    // Water stands in hollows of bare ground, not in grass.
    float wet = air.y;
    float bare = 1.0 - smoothstep(1.0, 1.25, albedo.g / max(albedo.r, 0.01));
    float puddle = wet * bare * smoothstep(0.66, 0.76, texture(grain, world.xy * 0.041).g);
    look.x += 0.05 * wet + 0.45 * puddle;
    look.y += 50.0 * wet;
    n = normalize(mix(n, vec3(0.0, 0.0, 1.0), puddle));
    albedo *= 1.0 - 0.45 * wet;
#endif
#ifdef WATER
    if (kind == meta.z) {
        look = vec4(0.75, 180.0, 0.0, 0.0);
        n = normalize(vec3((tile.gb - 0.5) * 0.06, 1.0));
    }
#endif
#ifdef INNER
    vec2 share = texture(sunlit, at).rg;
    share.r *= past_moving(world);
#else
    vec2 share = vec2(one_shadow(world), 1.0);
#endif
    vec3 colour = lit(albedo, n, to_eye / range, look, share.r, share.g);
    picture = vec4(seen(colour, range), 1.0);
    write_labels(meta.y, kind, flat_normal);
}
