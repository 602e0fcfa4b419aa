// Rays through two levels of compressed wide trees: one over all instances, and one over the triangles of each model
// (Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"). The includer
// declares the buffers `nodes`, `triangles` and `placements`.
#ifndef BVH_GLSL
#define BVH_GLSL

#include "lib/hit.glsl"
#include "lib/tree.glsl"

// A group of nodes or triangles that are still to be visited: where they begin, and a mask. Of nodes the upper eight bits say
// which are left, in the order of visits, and the lower eight which children are nodes; of triangles the lower 24 bits
// say which are left.
const uint LEAVES = 0x00ffffffu;
const uint NODE = 0x01000000u;
const uvec2 ROOT_GROUP = uvec2(0u, 0x80000000u);

// Deep enough for both levels of any scene: each halves what is left at least, in groups of eight, and what fits a
// device has fewer than 2^27 of both together.
const int STACK = 40;

// A ray as one level of the tree sees it.
struct Beam {
    vec3 origin;
    vec3 direction;
    vec3 inverse;
    uint octant;   // which child comes first, in each of four bytes
};

Beam beam(vec3 origin, vec3 direction) {
    // A direction without a component would divide by zero.
    const float LEAST = 1e-18;
    vec3 safe = vec3(abs(direction.x) < LEAST ? LEAST : direction.x, abs(direction.y) < LEAST ? LEAST : direction.y,
                     abs(direction.z) < LEAST ? LEAST : direction.z);
    uint octant = (direction.x < 0.0 ? 0u : 0x04040404u) | (direction.y < 0.0 ? 0u : 0x02020202u)
                | (direction.z < 0.0 ? 0u : 0x01010101u);
    return Beam(origin, direction, 1.0 / safe, octant);
}

// Which children of `node` the ray meets before `reach`: internal ones in the upper eight bits in the order of visits, leaves
// with their triangles below.
uint meets(Node node, Beam ray, float reach) {
    // Rounding of the planes' distances, twice over: no box that the ray grazes is missed.
    const float ROUNDING = 2.4e-7;
    vec3 scale = uintBitsToFloat((uvec3(node.exponents) >> uvec3(0, 8, 16) & 0xffu) << 23) * ray.inverse;
    vec3 base = (node.origin - ray.origin) * ray.inverse;
    vec3 slack = ROUNDING * (abs(base) + 255.0 * abs(scale));
    vec3 near_base = base - slack;
    vec3 far_base = base + slack;
    uint hits = 0u;
    for (int half_ = 0; half_ < 2; ++half_) {
        uint meta = node.meta[half_];
        // Children that are nodes have the bits 00011000 set, and no others have both.
        uint inner = (meta & (meta << 1)) & 0x10101010u;
        uint order = (meta ^ (ray.octant & ((inner >> 4) * 0xffu))) & 0x1f1f1f1fu;
        uint members = (meta >> 5) & 0x07070707u;
        uint near_x = ray.inverse.x < 0.0 ? node.greatest_x[half_] : node.least_x[half_];
        uint far_x = ray.inverse.x < 0.0 ? node.least_x[half_] : node.greatest_x[half_];
        uint near_y = ray.inverse.y < 0.0 ? node.greatest_y[half_] : node.least_y[half_];
        uint far_y = ray.inverse.y < 0.0 ? node.least_y[half_] : node.greatest_y[half_];
        uint near_z = ray.inverse.z < 0.0 ? node.greatest_z[half_] : node.least_z[half_];
        uint far_z = ray.inverse.z < 0.0 ? node.least_z[half_] : node.greatest_z[half_];
        for (int child = 0; child < 4; ++child) {
            int shift = 8 * child;
            // Signed numbers become floats faster.
            vec3 enter = vec3(ivec3(uvec3(near_x, near_y, near_z) >> shift & 0xffu)) * scale + near_base;
            vec3 leave = vec3(ivec3(uvec3(far_x, far_y, far_z) >> shift & 0xffu)) * scale + far_base;
            float first = max(max(enter.x, enter.y), max(enter.z, 0.0));
            float last = min(min(leave.x, leave.y), min(leave.z, reach));
            if (first <= last) hits |= (members >> shift & 0xffu) << (order >> shift & 0xffu);
        }
    }
    return hits;
}

// Distance along the ray, and weights of the second and the third corner; a negative distance where there is none. The
// test is watertight: neighbours judge the edge that they share by the same number, but for its sign, as long as nothing
// is contracted in one and not in the other (Davidovič et al. 2014, section 3.1; the form of Embree's robust mode).
vec3 crossing(Triangle triangle, Beam ray) {
    precise vec3 a = triangle.a - ray.origin;
    precise vec3 b = triangle.b - ray.origin;
    precise vec3 c = triangle.c - ray.origin;
    precise vec3 bc = c - b;
    precise vec3 ca = a - c;
    precise vec3 ab = b - a;
    precise vec3 of_a = cross(bc, c + b);
    precise vec3 of_b = cross(ca, a + c);
    precise vec3 of_c = cross(ab, b + a);
    precise vec3 weights = vec3(dot(of_a, ray.direction), dot(of_b, ray.direction), dot(of_c, ray.direction));
    float least = min(weights.x, min(weights.y, weights.z));
    float greatest = max(weights.x, max(weights.y, weights.z));
    if (least < 0.0 && greatest > 0.0) return vec3(-1.0);
    vec3 normal = cross(ab, ca);
    float facing = dot(normal, ray.direction);
    float whole = weights.x + weights.y + weights.z;
    if (facing == 0.0 || whole == 0.0) return vec3(-1.0);
    return vec3(dot(normal, a) / facing, weights.yz / whole);
}

// The nearest triangle before `reach`; any of them if `any_`.
//
// A device that runs many rays in step pays for every branch that one of them takes. So all go down through nodes together
// until each has leaves, and only then look at these (Aila & Laine 2009, "Understanding the Efficiency of Ray
// Traversal on GPUs": while-while).
Hit trace(vec3 origin, vec3 direction, float reach, const bool any_) {
    uvec2 stack[STACK];
    int depth = 0;
    int outside_ = -1;   // the depth at which the ray leaves the model that it is in; −1 between models
    uint placement = 0u;
    Beam ray = beam(origin, direction);
    uvec2 group = ROOT_GROUP;
    Hit hit = Hit(reach, 0.0, 0.0, 0u, NOTHING);
    while (true) {
        uvec2 leaves = uvec2(0u);
        while (group.y >= NODE) {
            int bit = findMSB(group.y);
            uint mask = group.y;
            group.y &= ~(1u << bit);
            if (group.y >= NODE) stack[depth++] = group;
            uint slot = uint(bit - 24) ^ (ray.octant & 7u);
            Node node = nodes[group.x + bitCount(mask & ~(0xffffffffu << slot) & 0xffu)];
            uint hits = meets(node, ray, hit.range);
            group = uvec2(node.first_child, hits >= NODE ? (hits & ~LEAVES) | (node.exponents >> 24) : 0u);
            leaves = uvec2(node.first_leaf, hits & LEAVES);
            if (leaves.y != 0u) break;
            // Back to what was left aside: nodes, or placements.
            if (group.y == 0u && depth > max(outside_, 0)) group = stack[--depth];
        }
        if (leaves.y == 0u && group.y < NODE) {
            leaves = group;
            group = uvec2(0u);
        }
        if (outside_ < 0) {
            if (leaves.y != 0u) {
                int bit = findMSB(leaves.y);
                leaves.y &= ~(1u << bit);
                if (group.y >= NODE) stack[depth++] = group;
                if (leaves.y != 0u) stack[depth++] = leaves;
                placement = leaves.x + uint(bit);
                Placement place = placements[placement];
                vec4 back = conjugate(place.rotation);
                ray = beam(rotate(back, origin - place.position) / place.scale, rotate(back, direction) / place.scale);
                outside_ = depth;
                // The root has no siblings.
                group = uvec2(place.root, ROOT_GROUP.y);
            }
        } else {
            while (leaves.y != 0u) {
                int bit = findMSB(leaves.y);
                leaves.y &= ~(1u << bit);
                uint index = leaves.x + uint(bit);
                vec3 found = crossing(triangles[index], ray);
                if (found.x > 0.0 && found.x < hit.range) {
                    hit = Hit(found.x, found.y, found.z, placement, index);
                    if (any_) return hit;
                }
            }
        }
        if (group.y == 0u) {
            if (depth == outside_) {
                outside_ = -1;
                ray = beam(origin, direction);
            }
            if (depth == 0) break;
            group = stack[--depth];
        }
    }
    return hit;
}

#endif
