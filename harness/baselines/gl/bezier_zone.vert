#version 330
// Before the geometry stage: which zone this is. There is no vertex data.
flat out int zone_number; // gl_PrimitiveID starts again where llvmpipe splits a draw

void main() { zone_number = gl_VertexID; }
