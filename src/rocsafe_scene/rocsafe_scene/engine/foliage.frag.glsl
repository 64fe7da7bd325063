// SPDX-License-Identifier: Apache-2.0
// Leaves and blades, as their corners are lit; the skin of crowns with a picture of leaves on it.
in vec3 shade;
in vec3 normal;
uniform ivec4 meta;             // class, instance, 0, 0
#ifdef SKIN
in vec2 place;
in vec2 sunward;
in float relief;
uniform sampler2D leaves;
#endif

void main() {
#ifdef SKIN
    // Bright is high, and lit where it falls towards the sun.
    float high = texture(leaves, place).r;
    float bright = relief * (high - 0.5 + 0.3 * (high - texture(leaves, place + sunward).r));
    picture = vec4(clamp(shade * (vec3(1.0) + bright * vec3(1.55, 1.4, 1.1)), 0.0, 1.0), 1.0);
#else
    picture = vec4(shade, 1.0);
#endif
    write_labels(meta.y, meta.x, normal);
}
