// A small mesh from the bytes of a fuzzer: any triangles between a few vertices, closed or not.
#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "bytes.hpp"
#include "palpate/scene/mesh.hpp"

namespace fuzz {

/// The mesh, or null if its builder refuses it with words. Any other exception is a fault.
inline std::shared_ptr<const palpate::scene::Mesh> soup(Bytes& bytes, double size) {
  const std::size_t vertices = 3 + bytes.below(14), triangles = 1 + bytes.below(24);
  std::vector<double> v;
  std::vector<std::int32_t> t;
  for (std::size_t i = 0; i < 3 * vertices; ++i) v.push_back(bytes.number(size));
  for (std::size_t i = 0; i < 3 * triangles; ++i) t.push_back(static_cast<std::int32_t>(bytes.below(vertices)));
  if (bytes.byte() == 0) t[0] = static_cast<std::int32_t>(vertices);
  try {
    return palpate::scene::Mesh::build(v, t);
  } catch (const std::invalid_argument& error) {
    require(error.what()[0] != '\0', "a refusal has words");
    return nullptr;
  }
}

}  // namespace fuzz
