// SPDX-License-Identifier: Apache-2.0
// Light, shadows, haze and the tone curve, shared by all surfaces.

// Compiled as needed, for a processor runs both sides of every branch: GLOSSY, WET, WATER, FAR where
// the finer shadow map ends, MOTION where shadows move, DISTANT where a pixel is wider than what is
// left out.

uniform mat4 p3d_ViewMatrixInverse;
uniform vec3 sun_direction;
uniform vec3 sun_light;
uniform vec3 zenith;
uniform vec3 horizon;
uniform vec3 bounce;
uniform vec4 air;               // haze per metre, wetness, exposure, brightness of the clouds
uniform sampler2DShadow near_shadow;
uniform sampler2DShadow far_shadow;
#ifdef MOTION
uniform sampler2DShadow moving_shadow;
#endif
uniform mat4 near_sun;          // world -> shadow map, 0 to 1
uniform mat4 far_sun;
uniform sampler2D canopy;       // blurred height of all that stands on the ground, metres
uniform vec4 canopy_area;       // west, south, 1 / width, 1 / height

vec3 sky(vec3 d) {
    float up = max(d.z, 0.0);
    vec3 colour = mix(horizon, zenith, 1.0 - exp(-3.6 * up));
    float near = max(dot(d, sun_direction), 0.0);
    float n8 = near * near; n8 *= n8; n8 *= n8;
    return colour + sun_light * (0.05 * n8);
}

#ifdef FAR
#define SHADOW_MAP far_shadow
#define TO_SHADOW far_sun
const float SLACK = 0.001;
#else
#define SHADOW_MAP near_shadow
#define TO_SHADOW near_sun
const float SLACK = 0.0006;
#endif

// Share of the sun that things that move let through.
float past_moving(vec3 world) {
#ifdef MOTION
    vec3 at = (near_sun * vec4(world, 1.0)).xyz;
    return textureLod(moving_shadow, vec3(at.xy, at.z - 0.0008), 0.0);
#else
    return 1.0;
#endif
}

float shadow(vec3 world, float slope) {
    vec3 at = (TO_SHADOW * vec4(world, 1.0)).xyz;
    float z = at.z - 0.6 * SLACK - SLACK * slope;
#ifdef DISTANT
    float still = textureLod(SHADOW_MAP, vec3(at.xy, z), 0.0);
#else
    vec2 texel = vec2(0.75) / vec2(textureSize(SHADOW_MAP, 0));
    float still = 0.25 * (texture(SHADOW_MAP, vec3(at.xy + texel * vec2(0.7, 0.3), z))
                 + texture(SHADOW_MAP, vec3(at.xy + texel * vec2(-0.3, 0.7), z))
                 + texture(SHADOW_MAP, vec3(at.xy + texel * vec2(-0.7, -0.3), z))
                 + texture(SHADOW_MAP, vec3(at.xy + texel * vec2(0.3, -0.7), z)));
#endif
    return still * past_moving(world);
}

float one_shadow(vec3 world) {
    vec3 at = (TO_SHADOW * vec4(world, 1.0)).xyz;
    return textureLod(SHADOW_MAP, vec3(at.xy, at.z - SLACK), 0.0);
}

float openness(vec3 world) {
    vec2 at = (world.xy - canopy_area.xy) * canopy_area.zw;
    float cover = max(texture(canopy, at).r - world.z, 0.0);
    return 1.0 / (1.0 + 0.42 * cover);
}

// look: gloss, sharpness, grain, through
vec3 lit(vec3 albedo, vec3 n, vec3 view, vec4 look, float sun_share, float open_share) {
    float facing = dot(n, sun_direction);
    float direct = max(facing, 0.0) + look.w * max(0.25 - 0.75 * facing, 0.0);
    vec3 ambient = mix(bounce, mix(horizon, zenith, 0.55) * 1.15, 0.5 + 0.5 * n.z) * open_share;
    vec3 colour = albedo * (sun_light * (direct * sun_share) + ambient);
#ifdef GLOSSY
    float gloss = look.x;
    if (gloss > 0.09) {
        float grazing = 1.0 - max(dot(n, view), 0.0);
        float fresnel = 0.06 + 0.94 * grazing * grazing * grazing * grazing;
        vec3 mirrored = reflect(-view, n);
        vec3 around = mirrored.z > 0.0 ? sky(mirrored) : bounce + 0.2 * horizon;
        float glint = max(dot(n, normalize(sun_direction + view)), 0.0);
        glint = pow(glint, look.y) * (0.012 * look.y + 0.15);
        colour += gloss * (fresnel * 1.6 * around * open_share + sun_light * (glint * sun_share));
    }
#endif
    return colour;
}

vec3 seen(vec3 colour, float range) {
    float clear = exp(-air.x * range);
    vec3 veil = horizon * 0.92 + sun_light * 0.02;
    colour = mix(veil, colour, clear) * air.z;
    colour *= 0.5;
    colour = colour * (2.51 * colour + 0.03) / (colour * (2.43 * colour + 0.59) + 0.14);
    return sqrt(clamp(colour, 0.0, 1.0));
}
