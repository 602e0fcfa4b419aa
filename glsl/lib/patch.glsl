// The lowest and the highest sample of one patch of ground and of the ring around it, metres.
struct Patch {
    float least;
    float greatest;
};
