// SPDX-License-Identifier: Apache-2.0
// Leaves and blades, as their corners are lit.
in vec3 shade;
in vec3 normal;
uniform ivec4 meta;             // class, instance, 0, 0

void main() {
    picture = vec4(shade, 1.0);
    write_labels(meta.y, meta.x, normal);
}
