// Maps of the shadows that plants cast, drawn from the sun, each of what lies within some distances from the eye (Dimitrov
// 2007, "Cascaded Shadow Maps").
#ifndef CAST_GLSL
#define CAST_GLSL

// A map. Places are relative to the eye: across and up in the plane that faces the sun, and along towards the sun.
struct Cast {
    vec3 right;
    vec3 up;
    vec2 centre;
    float half_size;   // of the square that it covers, metres
    float reach;       // nothing lies further than this from the eye along the sun's direction, metres
    float depth;       // up to this distance along the view it serves, metres; 0 if there is none
};

// Side of the square of maps that one image holds.
const int CAST_COLUMNS = 2;

// Where a point lies in the light: from −1 to 1 across and up, and metres along.
vec3 cast_place(Cast cast_, vec3 point) {
    vec3 from_eye = point - frame.eye;
    vec2 at = (vec2(dot(cast_.right, from_eye), dot(cast_.up, from_eye)) - cast_.centre) / cast_.half_size;
    return vec3(at, dot(frame.sun_direction, from_eye));
}

#endif
