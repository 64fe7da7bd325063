// SPDX-License-Identifier: Apache-2.0
// Leaves and blades: smaller than what light changes over, so lit at their corners, once for the
// many fragments that their edges have.
uniform mat4 p3d_ModelViewProjectionMatrix;
uniform mat4 p3d_ModelMatrix;
in vec4 p3d_Vertex;
in vec3 p3d_Normal;
in vec4 p3d_Color;
out vec3 shade;
out vec3 normal;
#ifdef SKIN
in vec2 p3d_MultiTexCoord0;
uniform float leaf_scale;       // 1 / width of the picture of leaves
out vec2 place;
out vec2 sunward;
out float relief;
#endif

void main() {
    gl_Position = p3d_ModelViewProjectionMatrix * p3d_Vertex;
    vec3 world = (p3d_ModelMatrix * p3d_Vertex).xyz;
    vec3 n = normalize(mat3(p3d_ModelMatrix) * p3d_Normal);
    vec3 to_eye = p3d_ViewMatrixInverse[3].xyz - world;
    float range = length(to_eye);
    float facing = dot(n, sun_direction);
    float direct = max(facing, 0.0) + 0.32 * max(0.35 - 0.65 * facing, 0.0);
    float share = one_shadow(world + 0.25 * sun_direction);
    float open_share = openness(world + vec3(0.0, 0.0, 0.6));
    vec3 albedo = p3d_Color.rgb * p3d_Color.rgb * (1.0 - 0.3 * air.y);
    vec3 ambient = mix(bounce, mix(horizon, zenith, 0.55) * 1.15, 0.5 + 0.5 * n.z) * open_share;
    vec3 colour = albedo * (sun_light * (direct * share) + ambient);
    float glint = max(dot(n, normalize(sun_direction + to_eye / range)), 0.0);
    glint *= glint; glint *= glint; glint *= glint;
    colour += sun_light * (0.018 * glint * share);
    shade = seen(colour, range);
    normal = n;
#ifdef SKIN
    // Shifted by where the tree stands: no two show the same.
    place = (p3d_ModelMatrix[3].xy + p3d_MultiTexCoord0) * leaf_scale;
    sunward = (transpose(mat3(p3d_ModelMatrix)) * sun_direction).xy * (0.08 * leaf_scale);
    // On the sides leaves hang past each other, and gaps between them show less.
    relief = 0.4 + 0.6 * smoothstep(0.55, 0.9, n.z);
#endif
}
