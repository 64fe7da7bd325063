// SPDX-License-Identifier: Apache-2.0
// Depth alone, of cameras without perspective too.
#version 330
uniform mat4 p3d_ModelViewProjectionMatrix;
uniform mat4 p3d_ModelViewMatrix;
in vec4 p3d_Vertex;
out float depth;

void main() {
    gl_Position = p3d_ModelViewProjectionMatrix * p3d_Vertex;
    depth = -(p3d_ModelViewMatrix * p3d_Vertex).z;
}
