#version 330
// The background: a ramp from the first row to the last.
uniform vec3 top, bottom;
in float down;
out vec4 colour;

void main() { colour = vec4(sqrt(mix(top, bottom, down)), 1.0); }
