/* SPDX-License-Identifier: Apache-2.0 */
#include "import/subdivide.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

using namespace OpenSubdiv;

namespace
{

/* Blender joins the UVs of corners that meet in a vertex where they are so close (STD_UV_CONNECT_LIMIT). */
const float UV_JOIN = 1e-4f;

/* Beyond this OpenSubdiv's int indices overflow. */
const double QUADS_MAX = INT32_MAX / 16;

/* What Far::PrimvarRefiner interpolates. Doubles: at level 10 differences of neighbours lose ten bits, and a mesh may
 * lie far from its origin. */
template <int N> struct Tuple {
    double v[N];

    void Clear() { std::memset(v, 0, sizeof v); }
    void AddWithWeight(const Tuple &other, double weight)
    {
        for (int i = 0; i < N; i++) v[i] += weight * other.v[i];
    }
};
using Point = Tuple<3>;
using Uv = Tuple<2>;

void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Stores v scaled to length 1; up where it has no direction. */
void store_unit(const double *v, float *out)
{
    double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    bool good = length > 0 && std::isfinite(length);
    for (int i = 0; i < 3; i++) out[i] = good ? float(v[i] / length) : float(i == 2);
}

/* Takes the sums of the refiner's limit masks one after another and keeps them as floats. */
template <int N> struct Sink {
    float *out;
    int current = -1;
    Tuple<N> sum;

    explicit Sink(float *numbers) : out(numbers) {}
    void flush()
    {
        for (int i = 0; i < N && current >= 0; i++) out[N * size_t(current) + i] = float(sum.v[i]);
    }
    Tuple<N> &operator[](int index)
    {
        if (index != current) {
            flush();
            current = index;
        }
        return sum;
    }
};

/* As Sink, for both tangents: keeps the normal. The refiner clears the first tangent, then the second. */
struct NormalSink {
    float *out;
    int current = -1;
    Point tangents[2];

    explicit NormalSink(float *numbers) : out(numbers) {}
    void flush()
    {
        double normal[3];
        if (current < 0) return;
        cross(tangents[0].v, tangents[1].v, normal);
        store_unit(normal, out + 3 * size_t(current));
    }
    Point &at(int index, int tangent)
    {
        if (index != current) {
            flush();
            current = index;
        }
        return tangents[tangent];
    }
};
struct TangentSink {
    NormalSink &normals;
    int tangent;

    Point &operator[](int index) { return normals.at(index, tangent); }
};

/* Corners of one vertex whose UVs agree share a value, so that a value belongs to one vertex. */
struct UvValues {
    std::vector<Far::Index> of_corner;
    std::vector<Uv> values;

    explicit UvValues(const scene_mesh &mesh) : of_corner(mesh.corner_count)
    {
        std::vector<int> first(mesh.vertex_count, -1), next;
        for (uint32_t corner = 0; corner < mesh.corner_count; corner++) {
            const float *uv = mesh.uvs + 2 * size_t(corner);
            int &head = first[mesh.corners[corner]], value = head;
            while (value >= 0 && !(std::fabs(values[value].v[0] - uv[0]) < UV_JOIN &&
                                   std::fabs(values[value].v[1] - uv[1]) < UV_JOIN))
                value = next[value];
            if (value < 0) {
                value = int(values.size());
                values.push_back(Uv{{uv[0], uv[1]}});
                next.push_back(head);
                head = value;
            }
            of_corner[corner] = value;
        }
    }
};

const Far::Index *as_indices(const uint32_t *indices) { return reinterpret_cast<const Far::Index *>(indices); }

std::unique_ptr<Far::TopologyRefiner> make_refiner(const scene_mesh &mesh, const UvValues *uvs)
{
    using Options = Sdc::Options;
    static_assert(int(UV_BOUNDARY_NONE) == int(Options::FVAR_LINEAR_NONE), "the order of OpenSubdiv");
    static_assert(int(UV_BOUNDARY_CORNERS_PLUS2) == int(Options::FVAR_LINEAR_CORNERS_PLUS2), "the order of OpenSubdiv");
    static_assert(int(UV_BOUNDARY_ALL) == int(Options::FVAR_LINEAR_ALL), "the order of OpenSubdiv");
    Options options;
    options.SetVtxBoundaryInterpolation(mesh.boundary == BOUNDARY_EDGE_ONLY ? Options::VTX_BOUNDARY_EDGE_ONLY
                                                                            : Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    options.SetFVarLinearInterpolation(Options::FVarLinearInterpolation(mesh.uv_boundary));
    options.SetCreasingMethod(Options::CREASE_UNIFORM);

    Far::TopologyDescriptor topology;
    topology.numVertices = int(mesh.vertex_count);
    topology.numFaces = int(mesh.face_count);
    topology.numVertsPerFace = reinterpret_cast<const int *>(mesh.face_sizes);
    topology.vertIndicesPerFace = as_indices(mesh.corners);
    topology.numCreases = int(mesh.crease_count);
    topology.creaseVertexIndexPairs = as_indices(mesh.crease_edges);
    topology.creaseWeights = mesh.crease_sharpness;
    topology.numCorners = int(mesh.sharp_corner_count);
    topology.cornerVertexIndices = as_indices(mesh.corner_vertices);
    topology.cornerWeights = mesh.corner_sharpness;
    Far::TopologyDescriptor::FVarChannel channel;
    if (uvs) {
        channel.numValues = int(uvs->values.size());
        channel.valueIndices = uvs->of_corner.data();
        topology.numFVarChannels = 1;
        topology.fvarChannels = &channel;
    }
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Sdc::SchemeType scheme = mesh.scheme == SUBDIVISION_BILINEAR ? Sdc::SCHEME_BILINEAR : Sdc::SCHEME_CATMARK;
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(topology, Factory::Options(scheme, options)));
    if (!refiner) throw std::runtime_error("OpenSubdiv refuses the cage: a vertex or face has too many neighbours");
    return refiner;
}

template <class T> T *allocate(size_t count)
{
    void *memory = std::malloc((count + 1) * sizeof(T));
    if (!memory) throw std::bad_alloc();
    return static_cast<T *>(memory);
}

/* Interpolates `values` through all levels. */
template <class T, class Interpolate>
void refine(const Far::TopologyRefiner &refiner, std::vector<T> &values, bool uv, Interpolate interpolate)
{
    for (int level = 1; level <= refiner.GetMaxLevel(); level++) {
        const Far::TopologyLevel &topology = refiner.GetLevel(level);
        std::vector<T> finer(uv ? topology.GetNumFVarValues(0) : topology.GetNumVertices());
        interpolate(level, values.data(), finer.data());
        values.swap(finer);
    }
}

/* Gives vertices where no limit normal exists (at sharp edges and corners, and wherever the scheme is bilinear) the
 * mean of the facets' normals, one for each side of the sharp edges, and splits them where the sides differ. */
class SharpNormals
{
  public:
    SharpNormals(const Far::TopologyLevel &topology, bool bilinear, const float *positions, subdivided &output)
        : level(topology), all(bilinear), vertex_positions(positions), out(output)
    {
    }

    void apply()
    {
        for (int vertex = 0; vertex < level.GetNumVertices(); vertex++) {
            Sdc::Crease::Rule rule = level.GetVertexRule(vertex);
            if (!all && (rule == Sdc::Crease::RULE_SMOOTH || rule == Sdc::Crease::RULE_DART)) continue;
            int sides = find_sides(vertex);
            if (sides > 1 || all || rule == Sdc::Crease::RULE_CORNER) assign(vertex);
        }
        append_copies();
    }

  private:
    struct Copy {
        uint32_t original, side, index;
    };

    const Far::TopologyLevel &level;
    bool all;
    const float *vertex_positions; /* of the topology's vertices */
    subdivided &out;
    std::vector<int> side_of_face; /* of the faces around a vertex */
    std::vector<Point> side_normals;
    std::vector<Copy> of_vertex;     /* the (vertex of `out`, side) pairs at a vertex */
    std::vector<uint32_t> originals; /* of the vertices to append to `out` */
    std::vector<float> copy_normals;

    /* Numbers the sides: faces that smooth edges join are on one. */
    int find_sides(int vertex)
    {
        Far::ConstIndexArray faces = level.GetVertexFaces(vertex), edges = level.GetVertexEdges(vertex);
        side_of_face.resize(faces.size());
        for (int i = 0; i < faces.size(); i++) side_of_face[i] = i;
        for (int i = 0; i < edges.size(); i++) {
            Far::ConstIndexArray pair = level.GetEdgeFaces(edges[i]);
            if (pair.size() != 2 || level.GetEdgeSharpness(edges[i]) > 0) continue;
            int a = -1, b = -1;
            for (int k = 0; k < faces.size(); k++) {
                a = faces[k] == pair[0] ? side_of_face[k] : a;
                b = faces[k] == pair[1] ? side_of_face[k] : b;
            }
            for (int &side : side_of_face) side = side == b ? a : side;
        }
        int sides = 0;
        for (int i = 0; i < faces.size(); i++)
            if (side_of_face[i] == i) sides++;
        return sides;
    }

    void assign(int vertex)
    {
        Far::ConstIndexArray faces = level.GetVertexFaces(vertex);
        Far::ConstLocalIndexArray places = level.GetVertexFaceLocalIndices(vertex);
        side_normals.assign(faces.size(), Point{{0, 0, 0}});
        for (int i = 0; i < faces.size(); i++) add_facet(faces[i], places[i], side_normals[side_of_face[i]]);
        of_vertex.clear();
        for (int i = 0; i < faces.size(); i++) {
            uint32_t side = side_of_face[i], &corner = out.quads[4 * size_t(faces[i]) + places[i]];
            corner = vertex_of_side(corner, side);
        }
    }

    /* Adds the unit normal that face has at its corner `place`, weighted by the angle there. */
    void add_facet(int face, int place, Point &sum) const
    {
        Far::ConstIndexArray corners = level.GetFaceVertices(face);
        const float *p = vertex_positions + 3 * size_t(corners[place]);
        const float *after = vertex_positions + 3 * size_t(corners[(place + 1) % 4]);
        const float *before = vertex_positions + 3 * size_t(corners[(place + 3) % 4]);
        double a[3], b[3], normal[3], dot = 0, length = 0;
        for (int i = 0; i < 3; i++) {
            a[i] = double(after[i]) - p[i];
            b[i] = double(before[i]) - p[i];
            dot += a[i] * b[i];
        }
        cross(a, b, normal);
        for (double n : normal) length += n * n;
        length = std::sqrt(length);
        if (length > 0) sum.AddWithWeight(Point{{normal[0], normal[1], normal[2]}}, std::atan2(length, dot) / length);
    }

    /* The vertex of `out` for one side: `original` itself for the first side that asks, a copy for the others. */
    uint32_t vertex_of_side(uint32_t original, uint32_t side)
    {
        bool taken = false;
        for (const Copy &copy : of_vertex) {
            if (copy.original == original && copy.side == side) return copy.index;
            taken = taken || copy.original == original;
        }
        uint32_t index = original;
        if (taken) {
            index = out.vertex_count + uint32_t(originals.size());
            originals.push_back(original);
            copy_normals.resize(copy_normals.size() + 3);
        }
        store_unit(side_normals[side].v,
                   taken ? &copy_normals[copy_normals.size() - 3] : out.normals + 3 * size_t(original));
        of_vertex.push_back(Copy{original, side, index});
        return index;
    }

    void append_copies()
    {
        size_t old = out.vertex_count, count = old + originals.size();
        if (originals.empty()) return;
        grow(out.positions, 3 * count);
        grow(out.normals, 3 * count);
        if (out.uvs) grow(out.uvs, 2 * count);
        for (size_t i = 0; i < originals.size(); i++) {
            std::memcpy(out.positions + 3 * (old + i), out.positions + 3 * size_t(originals[i]), 3 * sizeof(float));
            if (out.uvs) std::memcpy(out.uvs + 2 * (old + i), out.uvs + 2 * size_t(originals[i]), 2 * sizeof(float));
        }
        std::memcpy(out.normals + 3 * old, copy_normals.data(), copy_normals.size() * sizeof(float));
        out.vertex_count = uint32_t(count);
    }

    static void grow(float *&numbers, size_t count)
    {
        float *larger = static_cast<float *>(std::realloc(numbers, count * sizeof(float)));
        if (!larger) throw std::bad_alloc();
        numbers = larger;
    }
};

using MallocFloats = std::unique_ptr<float, void (*)(void *)>;

/* One vertex a UV value instead of one a vertex of the topology. */
void spread_to_values(const Far::TopologyLevel &topology, subdivided &out, MallocFloats &positions,
                      MallocFloats &normals)
{
    out.vertex_count = uint32_t(topology.GetNumFVarValues(0));
    out.positions = allocate<float>(3 * size_t(out.vertex_count));
    if (normals) out.normals = allocate<float>(3 * size_t(out.vertex_count));
    /* Loose vertices have a value that no face names. */
    for (uint32_t i = 0; i < out.vertex_count; i++) {
        std::memcpy(out.positions + 3 * size_t(i), positions.get(), 3 * sizeof(float));
        if (normals) std::memcpy(out.normals + 3 * size_t(i), normals.get(), 3 * sizeof(float));
    }
    for (uint32_t face = 0; face < out.quad_count; face++) {
        Far::ConstIndexArray corners = topology.GetFaceVertices(int(face));
        Far::ConstIndexArray values = topology.GetFaceFVarValues(int(face));
        for (int i = 0; i < 4; i++) {
            out.quads[4 * size_t(face) + i] = uint32_t(values[i]);
            std::memcpy(out.positions + 3 * size_t(values[i]), positions.get() + 3 * size_t(corners[i]),
                        3 * sizeof(float));
            if (normals)
                std::memcpy(out.normals + 3 * size_t(values[i]), normals.get() + 3 * size_t(corners[i]),
                            3 * sizeof(float));
        }
    }
}

void subdivide_or_throw(const scene_mesh &mesh, int level, subdivided &out)
{
    /* OpenSubdiv would print. */
    static std::once_flag once;
    std::call_once(once, [] {
        Far::SetErrorCallback([](Far::ErrorType, const char *) {});
        Far::SetWarningCallback([](const char *) {});
    });
    for (uint32_t f = 0; f < mesh.face_count && level < 1; f++)
        if (mesh.face_sizes[f] != 4) level = 1;
    if (subdivide_quads(&mesh, level) > QUADS_MAX) throw std::runtime_error("too many quads");

    std::unique_ptr<UvValues> uvs(mesh.uvs ? new UvValues(mesh) : nullptr);
    std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(mesh, uvs.get());
    if (level > 0) {
        Far::TopologyRefiner::UniformOptions options(level);
        options.fullTopologyInLastLevel = true;
        refiner->RefineUniform(options);
    }
    Far::PrimvarRefinerReal<double> interpolator(*refiner);
    const Far::TopologyLevel &topology = refiner->GetLevel(refiner->GetMaxLevel());
    out.quad_count = uint32_t(topology.GetNumFaces());
    out.quads = allocate<uint32_t>(4 * size_t(out.quad_count));

    std::vector<Point> points(mesh.vertex_count);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        for (int axis = 0; axis < 3; axis++) points[i].v[axis] = mesh.positions[3 * size_t(i) + axis];
    refine(*refiner, points, false,
           [&](int l, Point *source, Point *finer) { interpolator.Interpolate(l, source, finer); });
    MallocFloats positions(allocate<float>(3 * size_t(topology.GetNumVertices())), std::free);
    MallocFloats normals(mesh.smooth ? allocate<float>(3 * size_t(topology.GetNumVertices())) : nullptr, std::free);
    Sink<3> position_sink(positions.get());
    const Point *source = points.data();
    if (mesh.smooth) {
        NormalSink normal_sink(normals.get());
        TangentSink tangent1{normal_sink, 0}, tangent2{normal_sink, 1};
        interpolator.Limit(source, position_sink, tangent1, tangent2);
        normal_sink.flush();
    } else {
        interpolator.Limit(source, position_sink);
    }
    position_sink.flush();
    std::vector<Point>().swap(points);

    if (uvs) {
        refine(*refiner, uvs->values, true,
               [&](int l, Uv *coarse, Uv *finer) { interpolator.InterpolateFaceVarying(l, coarse, finer); });
        out.uvs = allocate<float>(2 * size_t(topology.GetNumFVarValues(0)));
        Sink<2> uv_sink(out.uvs);
        const Uv *values = uvs->values.data();
        interpolator.LimitFaceVarying(values, uv_sink);
        uv_sink.flush();
        uvs.reset();
    }
    const float *vertex_positions = positions.get();
    if (out.uvs) {
        spread_to_values(topology, out, positions, normals);
    } else {
        out.vertex_count = uint32_t(topology.GetNumVertices());
        for (uint32_t face = 0; face < out.quad_count; face++) {
            Far::ConstIndexArray corners = topology.GetFaceVertices(int(face));
            for (int i = 0; i < 4; i++) out.quads[4 * size_t(face) + i] = uint32_t(corners[i]);
        }
        out.positions = positions.release();
        out.normals = normals.release();
    }
    if (out.normals) {
        SharpNormals sharp(topology, mesh.scheme == SUBDIVISION_BILINEAR, vertex_positions, out);
        sharp.apply();
    }

    std::vector<uint32_t> slots(mesh.face_count, 0);
    if (mesh.face_materials) slots.assign(mesh.face_materials, mesh.face_materials + mesh.face_count);
    for (int l = 1; l <= refiner->GetMaxLevel(); l++) {
        std::vector<uint32_t> finer(refiner->GetLevel(l).GetNumFaces());
        interpolator.InterpolateFaceUniform(l, slots.data(), finer);
        slots.swap(finer);
    }
    out.slots = allocate<uint32_t>(slots.size());
    std::memcpy(out.slots, slots.data(), slots.size() * sizeof slots[0]);
}

} // namespace

double subdivide_quads(const scene_mesh *mesh, int level)
{
    return level > 0 ? mesh->corner_count * std::pow(4., level - 1) : mesh->face_count;
}

bool subdivide(const scene_mesh *mesh, int level, subdivided *out, char error[SCENE_ERROR])
{
    *out = subdivided{};
    try {
        subdivide_or_throw(*mesh, level, *out);
        return true;
    } catch (const std::bad_alloc &) {
        std::snprintf(error, SCENE_ERROR, "mesh \"%s\": out of memory at subdivision level %d", mesh->name, level);
    } catch (const std::exception &exception) {
        std::snprintf(error, SCENE_ERROR, "mesh \"%s\": %s", mesh->name, exception.what());
    }
    subdivide_free(out);
    return false;
}

void subdivide_free(subdivided *s)
{
    std::free(s->positions);
    std::free(s->normals);
    std::free(s->uvs);
    std::free(s->quads);
    std::free(s->slots);
    *s = subdivided{};
}
