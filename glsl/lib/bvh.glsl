// Rays through two levels of compressed wide trees: one over all instances, and one over the triangles of each model
// (Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"). The includer
// declares the texel buffers `nodes`, `triangles` and `placements`, the image `height`, and the `push` with the `lattice` of the land.
#ifndef BVH_GLSL
#define BVH_GLSL

#include "lib/ground.glsl"
#include "lib/hit.glsl"
#include "lib/placements.glsl"
#include "lib/tree.glsl"
#include "lib/triangles.glsl"

// A group of nodes or triangles that are still to be visited: where they begin, and a mask. Of nodes the upper eight bits say
// which are left, in the order of visits, and the lower eight which children are nodes; of triangles the lower 24 bits
// say which are left.
const uint LEAVES = 0x00ffffffu;
const uint NODE = 0x01000000u;
const uvec2 ROOT_GROUP = uvec2(0u, 0x80000000u);

// Deep enough for both levels of any scene: each halves what is left at least, in groups of eight, and what fits a
// device has fewer than 2^27 of both together.
const int STACK = 40;

// A level of the land's tree has an eighth of the nodes of the next, and there are eight levels at most.
const int LAND_STACK = 10;

// The placement of the land.
const uint LAND = 0u;

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

Node node_at(uint index) {
    int at = 5 * int(index);
    uvec4 corner = texelFetch(nodes, at);
    uvec4 links = texelFetch(nodes, at + 1);
    uvec4 x = texelFetch(nodes, at + 2);
    uvec4 y = texelFetch(nodes, at + 3);
    uvec4 z = texelFetch(nodes, at + 4);
    return Node(uintBitsToFloat(corner.xyz), corner.w, links.x, links.y, links.zw, x.xy, x.zw, y.xy, y.zw, z.xy, z.zw);
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
// Corners are seen from the ray's origin.
vec3 crossing(vec3 a, vec3 b, vec3 c, vec3 direction) {
    precise vec3 bc = c - b;
    precise vec3 ca = a - c;
    precise vec3 ab = b - a;
    precise vec3 of_a = cross(bc, c + b);
    precise vec3 of_b = cross(ca, a + c);
    precise vec3 of_c = cross(ab, b + a);
    precise vec3 weights = vec3(dot(of_a, direction), dot(of_b, direction), dot(of_c, direction));
    float least = min(weights.x, min(weights.y, weights.z));
    float greatest = max(weights.x, max(weights.y, weights.z));
    if (least < 0.0 && greatest > 0.0) return vec3(-1.0);
    vec3 normal = cross(ab, ca);
    float facing = dot(normal, direction);
    float whole = weights.x + weights.y + weights.z;
    if (facing == 0.0 || whole == 0.0) return vec3(-1.0);
    return vec3(dot(normal, a) / facing, weights.yz / whole);
}

void nearer(inout Hit hit, vec3 found, uint placement, uint triangle) {
    if (found.x > 0.0 && found.x < hit.range) hit = Hit(found.x, found.y, found.z, placement, triangle);
}

// Looks at the four triangles of a leaf of the land. Beyond the last column they have no width and are not met.
void cross_tile(inout Hit hit, uint leaf, Beam ray) {
    int columns = imageSize(height).x - 1;
    ivec2 at = tile_cell(leaf);
    ivec2 beyond = min(at + TILE, ivec2(columns));
    int middle = at.x + 1;
    vec3 nw = ground_corner(at, push.lattice) - ray.origin;
    vec3 n = ground_corner(ivec2(middle, at.y), push.lattice) - ray.origin;
    vec3 ne = ground_corner(ivec2(beyond.x, at.y), push.lattice) - ray.origin;
    vec3 sw = ground_corner(ivec2(at.x, beyond.y), push.lattice) - ray.origin;
    vec3 s = ground_corner(ivec2(middle, beyond.y), push.lattice) - ray.origin;
    vec3 se = ground_corner(beyond, push.lattice) - ray.origin;
    uint first = GRID | uint(at.y * columns + at.x) << 1;
    nearer(hit, crossing(nw, sw, n, ray.direction), LAND, first);
    nearer(hit, crossing(n, sw, s, ray.direction), LAND, first + 1u);
    nearer(hit, crossing(n, s, ne, ray.direction), LAND, first + 2u);
    nearer(hit, crossing(ne, s, se, ray.direction), LAND, first + 3u);
}

// What of a node's children the ray meets: nodes in `group` and leaves in `leaves`. `group` has a child that is left and is not
// empty; what remains of it goes on the stack.
#define VISIT(ray, reach)                                                                                          \
    int bit = findMSB(group.y);                                                                                    \
    uint mask = group.y;                                                                                           \
    group.y &= ~(1u << bit);                                                                                       \
    if (group.y >= NODE) stack[depth++] = group;                                                                   \
    uint slot = uint(bit - 24) ^ (ray.octant & 7u);                                                                \
    Node node = node_at(group.x + bitCount(mask & ~(0xffffffffu << slot) & 0xffu));                                \
    uint hits = meets(node, ray, reach);                                                                           \
    group = uvec2(node.first_child, hits >= NODE ? (hits & ~LEAVES) | (node.exponents >> 24) : 0u);                \
    leaves = uvec2(node.first_leaf, hits & LEAVES);

// The land, whose placement is the first.
//
// A device that runs many rays in step pays for every branch that one of them takes. So all go down through nodes together
// until each has leaves, and only then look at these (Aila & Laine 2009, "Understanding the Efficiency of Ray
// Traversal on GPUs": while-while). And so the land comes before all else: its leaves need other work.
void trace_land(inout Hit hit, vec3 origin, vec3 direction, const bool any_) {
    uvec2 stack[LAND_STACK];
    int depth = 0;
    Beam ray = beam(origin, direction);
    uvec2 group = uvec2(placement_at(LAND).root, ROOT_GROUP.y);
    while (true) {
        uvec2 leaves = uvec2(0u);
        while (group.y >= NODE) {
            VISIT(ray, hit.range)
            if (leaves.y != 0u) break;
            if (group.y == 0u && depth > 0) group = stack[--depth];
        }
        while (leaves.y != 0u) {
            int bit = findMSB(leaves.y);
            leaves.y &= ~(1u << bit);
            cross_tile(hit, leaves.x + uint(bit), ray);
            if (any_ && hit.triangle != NOTHING) return;
        }
        if (group.y == 0u) {
            if (depth == 0) break;
            group = stack[--depth];
        }
    }
}

// What stands on the land.
void trace_models(inout Hit hit, vec3 origin, vec3 direction, const bool any_) {
    uvec2 stack[STACK];
    int depth = 0;
    int outside_ = -1;   // the depth at which the ray leaves the model that it is in; −1 between models
    uint placement = 0u;
    Beam ray = beam(origin, direction);
    uvec2 group = ROOT_GROUP;
    while (true) {
        uvec2 leaves = uvec2(0u);
        while (group.y >= NODE) {
            VISIT(ray, hit.range)
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
                Placement place = placement_at(placement);
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
                Triangle triangle = triangle_at(index);
                vec3 a = triangle.a - ray.origin;
                vec3 b = triangle.b - ray.origin;
                vec3 c = triangle.c - ray.origin;
                nearer(hit, crossing(a, b, c, ray.direction), placement, index);
                if (any_ && hit.triangle != NOTHING) return;
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
}

Hit trace(vec3 origin, vec3 direction, float reach, const bool any_) {
    Hit hit = Hit(reach, 0.0, 0.0, 0u, NOTHING);
    trace_land(hit, origin, direction, any_);
    if (any_ && hit.triangle != NOTHING) return hit;
    trace_models(hit, origin, direction, any_);
    return hit;
}

#endif
