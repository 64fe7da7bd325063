// SPDX-License-Identifier: Apache-2.0
// Seen from straight above: how much sun and how much sky each place of the ground gets.
in vec3 world;
in vec3 normal;

void main() {
    // Eight places around, wider where more stands in the way: soft edges.
    float sum = 0.0;
    for (int k = 0; k < 8; ++k) {
        float turn = 2.399963 * float(k);
        float reach = 0.17 * sqrt((float(k) + 0.5) / 8.0);
        vec3 at = (near_sun * vec4(world + vec3(cos(turn), sin(turn), 0.0) * reach, 1.0)).xyz;
        sum += texture(near_shadow, vec3(at.xy, at.z - 0.0004));
    }
    picture = vec4(sum / 8.0, openness(world), 0.0, 1.0);
    depth_bits = label_bits = normal_bits = vec4(0.0);
}
