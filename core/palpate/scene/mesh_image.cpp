// A mesh and its index as one block of bytes. The layout is that of this machine and of this version of the library.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "palpate/scene/mesh.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/types/index.hpp"

namespace palpate::scene {
namespace {

constexpr std::uint64_t kMagic = 0x32687365'6d6c6170;  // "palmesh2"

/// Bytes to insert at `position`, so that an array `before` bytes later is aligned.
std::size_t padding(std::size_t position, std::size_t before) {
  return (kImageAlignment - (position + before) % kImageAlignment) % kImageAlignment;
}

/// Collects the pieces of an image. Each array begins at a multiple of kImageAlignment.
class Writer {
 public:
  template <class T>
  void array(const T* values, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(values);
    head().insert(head().end(), bytes, bytes + n * sizeof(T));
    size_ += n * sizeof(T);
  }
  template <class T>
  void scalar(const T& value) {
    array(&value, 1);
  }
  template <class List>
  void list(const List& values) {
    align(sizeof(std::size_t));
    scalar(values.size());
    refer(values.data(), values.size());
  }
  /// Prepares for arrays whose sizes are two scalars that follow now.
  void before_two_sizes() { align(2 * sizeof(std::size_t)); }
  template <class T>
  void shared(const std::shared_ptr<T[]>& values, std::size_t n) {
    refer(values.get(), n);
  }
  [[nodiscard]] std::vector<ImagePiece> pieces() && { return std::move(pieces_); }

 private:
  /// Bytes of the image's own that follow the array of the last piece.
  std::vector<std::uint8_t>& head() {
    if (pieces_.empty() || pieces_.back().array.data() != nullptr) pieces_.emplace_back();
    return pieces_.back().head;
  }
  void align(std::size_t before) {
    const std::size_t pad = padding(size_, before);
    head().resize(head().size() + pad);
    size_ += pad;
  }
  template <class T>
  void refer(const T* values, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kImageAlignment);
    if (n == 0) return;
    head();
    pieces_.back().array = {reinterpret_cast<const std::uint8_t*>(values), n * sizeof(T)};
    size_ += n * sizeof(T);
  }

  std::vector<ImagePiece> pieces_;
  std::size_t size_ = 0;
};

/// Reads an image whose first byte is aligned; arrays stay in it.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> in) : begin_(in.data()), in_(in) {}

  template <class T>
  void array(T* values, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    require_left<T>(n);
    if (n > 0) std::memcpy(values, in_.data(), n * sizeof(T));
    in_ = in_.subspan(n * sizeof(T));
  }
  template <class T>
  void scalar(T& value) {
    array(&value, 1);
  }
  void scalar(bool& value) {
    std::uint8_t byte = 0;
    array(&byte, 1);
    if (byte > 1) throw std::invalid_argument("mesh: the stored index is damaged");  // no other byte is a bool
    value = byte == 1;
  }
  template <class T>
  void list(Stored<T>& values) {
    values = Stored<T>::inside(next_list<T>());
  }
  template <class T>
  void list(std::vector<T>& values) {
    const std::span<const T> found = next_list<T>();
    values.assign(found.begin(), found.end());
  }
  void before_two_sizes() { align(2 * sizeof(std::size_t)); }
  template <class T>
  void shared(std::shared_ptr<T[]>& values, std::size_t n) {
    const std::span<const T> found = next<T>(n);
    values = std::shared_ptr<T[]>(std::shared_ptr<void>(), const_cast<T*>(found.data()));  // nothing writes to it
  }
  [[nodiscard]] bool at_end() const { return in_.empty(); }

 private:
  template <class T>
  void require_left(std::size_t n) const {
    if (n > in_.size() / sizeof(T)) throw std::invalid_argument("mesh: the stored index is truncated");
  }
  void align(std::size_t before) {
    const std::size_t pad = padding(static_cast<std::size_t>(in_.data() - begin_), before);
    require_left<std::uint8_t>(pad);
    in_ = in_.subspan(pad);
  }
  template <class T>
  std::span<const T> next(std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    require_left<T>(n);
    const std::span<const T> found(reinterpret_cast<const T*>(in_.data()), n);
    in_ = in_.subspan(n * sizeof(T));
    return found;
  }
  template <class T>
  std::span<const T> next_list() {
    align(sizeof(std::size_t));
    std::size_t n = 0;
    scalar(n);
    return next<T>(n);
  }

  const std::uint8_t* begin_;
  std::span<const std::uint8_t> in_;
};

/// Passes every field to the archive, in the same order for writing and for reading.
template <class Archive, class Impl>
void visit(Archive& archive, Impl& m) {
  archive.list(m.vertices);
  archive.list(m.triangles);
  auto& t = m.topology;
  archive.list(t.twin);
  archive.list(t.normal);
  archive.list(t.normals);
  archive.list(t.smooth_vertex);
  archive.scalar(t.height);
  archive.scalar(t.branching_edges);
  archive.scalar(t.flat_triangles);
  archive.scalar(t.closed);
  archive.list(t.rims);
  archive.list(t.inconsistent_pairs);
  auto& b = m.bvh;
  archive.before_two_sizes();
  archive.scalar(b.node_count);
  archive.scalar(b.block_count);
  archive.shared(b.nodes, b.node_count);
  archive.shared(b.blocks, b.block_count);
  archive.shared(b.ids, b.block_count * kTrianglesPerBlock);
  archive.array(b.centre, 3);
  archive.scalar(b.scale);
  auto& r = m.report;
  for (auto* count : {&r.vertices, &r.triangles, &r.degenerate, &r.duplicate, &r.flat, &r.components, &r.boundary_edges,
                      &r.branching_edges, &r.inconsistent_edges, &r.flipped, &r.inverted})
    archive.scalar(*count);
  archive.scalar(r.two_sided);
  archive.scalar(r.closed);
  archive.scalar(r.volume);
  archive.array(r.lowest.data(), 3);
  archive.array(r.highest.data(), 3);
}

/// Whether all values lie in [lowest, end).
bool within(std::span<const std::int32_t> values, std::int64_t lowest, std::size_t end) {
  return std::ranges::all_of(values, [&](std::int32_t i) { return i >= lowest && i < static_cast<std::int64_t>(end); });
}

/// Whether the box of a lane contains no point and is infinitely far from each, so that no query visits its child.
bool is_empty(const BvhNode& node, std::size_t lane) {
  constexpr float kNowhere = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    if (node.lo[k][lane] != kNowhere || node.hi[k][lane] != -kNowhere) return false;
  }
  return true;
}

/// Whether every child is a later node, a block, or an unused lane (child 0 with an empty box), every node but the root
/// has one parent, and no node is deeper than a query's stack allows.
bool is_tree(const Bvh& bvh) {
  if (bvh.node_count == 0) return false;
  std::vector<int> level(bvh.node_count, 0);  // 1: the root; 0: no parent was met
  level[0] = 1;
  for (std::size_t n = 0; n < bvh.node_count; ++n) {
    const BvhNode& node = bvh.nodes[n];
    if (level[n] == 0 || level[n] > kBvhLevels) return false;
    for (std::size_t i = 0; i < 8; ++i) {
      const std::int32_t child = node.child[i];
      if (child > 0) {
        const std::size_t c = to_index(child);
        if (c <= n || c >= bvh.node_count || level[c] != 0) return false;
        level[c] = level[n] + 1;
      } else {
        const bool unused = child == 0 && is_empty(node, i);
        const bool block = child < 0 && to_index(~child) < bvh.block_count;
        if (!unused && !block) return false;
      }
    }
  }
  return true;
}

/// Whether every half-edge is the twin of its twin. A walk around a vertex ends only then.
bool are_twins(std::span<const std::int32_t> twin) {
  for (std::size_t i = 0; i < twin.size(); ++i) {
    if (twin[i] >= 0 && twin[to_index(twin[i])] != static_cast<std::int32_t>(i)) return false;
  }
  return true;
}

bool is_consistent(const Mesh::Impl& m) {
  const Topology& t = m.topology;
  const std::size_t corners = m.triangles.size(), normals = t.smooth_vertex.size();
  return corners > 0 && corners % 3 == 0 && m.vertices.size() % 3 == 0 && t.normals.size() == 3 * normals &&
         t.twin.size() == corners && t.normal.size() == corners && within(m.triangles, 0, m.vertices.size() / 3) &&
         within(t.twin, -1, corners) && are_twins(t.twin) && within(t.normal, 0, normals) &&
         within(t.rims, 0, corners) &&
         std::ranges::all_of(t.inconsistent_pairs,
                             [&](const HalfEdgePair& pair) { return within(pair, 0, corners); }) &&
         within({m.bvh.ids.get(), m.bvh.block_count * kTrianglesPerBlock}, 0, corners / 3) && is_tree(m.bvh);
}

}  // namespace

std::vector<ImagePiece> Mesh::image_pieces() const {
  Writer writer;
  writer.scalar(kMagic);
  visit(writer, std::as_const(*impl_));
  return std::move(writer).pieces();
}

std::vector<std::uint8_t> Mesh::image() const {
  std::vector<std::uint8_t> out;
  for (const ImagePiece& piece : image_pieces()) {
    out.insert(out.end(), piece.head.begin(), piece.head.end());
    out.insert(out.end(), piece.array.begin(), piece.array.end());
  }
  return out;
}

std::shared_ptr<const Mesh> Mesh::from_image(std::span<const std::uint8_t> image) {
  std::shared_ptr<Mesh> mesh(new Mesh);
  Impl& m = *mesh->impl_;
  if (reinterpret_cast<std::uintptr_t>(image.data()) % kImageAlignment != 0) {
    m.image.reset(new Aligned[image.size() / sizeof(Aligned) + 1]);
    std::copy(image.begin(), image.end(), m.image[0].bytes);
    image = {m.image[0].bytes, image.size()};
  }
  Reader reader(image);
  std::uint64_t magic = 0;
  reader.scalar(magic);
  if (magic != kMagic) throw std::invalid_argument("mesh: these bytes are no stored index");
  visit(reader, m);
  if (!reader.at_end() || !is_consistent(m)) throw std::invalid_argument("mesh: the stored index is damaged");
  return mesh;
}

}  // namespace palpate::scene
