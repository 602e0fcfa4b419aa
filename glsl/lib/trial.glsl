// What programs that are tried by themselves are asked, and answer.
#ifndef TRIAL_GLSL
#define TRIAL_GLSL

// One direction of light.
struct Trial {
    vec3 direction;
    float density;   // 1/sr
    vec3 value;      // times cosine; over density, where the direction is chosen
};

#endif
