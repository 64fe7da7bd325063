// SPDX-License-Identifier: Apache-2.0
#version 330
uniform mat4 p3d_ModelViewProjectionMatrix;
uniform mat4 p3d_ModelViewMatrix;
uniform mat4 p3d_ModelMatrix;
uniform mat4 p3d_ViewMatrixInverse;
in vec4 p3d_Vertex;
in vec3 p3d_Normal;
in vec4 p3d_Color;
in vec2 p3d_MultiTexCoord0;
out vec3 world;
out vec3 normal;
out vec4 tint;
out vec2 place;
out float depth;
out vec3 to_eye;

void main() {
    gl_Position = p3d_ModelViewProjectionMatrix * p3d_Vertex;
    depth = -(p3d_ModelViewMatrix * p3d_Vertex).z;
    world = (p3d_ModelMatrix * p3d_Vertex).xyz;
    normal = mat3(p3d_ModelMatrix) * p3d_Normal;
    to_eye = p3d_ViewMatrixInverse[3].xyz - world;
    tint = p3d_Color;
    place = p3d_MultiTexCoord0;
}
