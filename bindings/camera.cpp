#include <nanobind/ndarray.h>

#include <cstring>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/plant/depth_image.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using plant::DepthImage;
using plant::Pinhole;

void draw(DepthImage& image, const Points& vertices_O, const Triangles& triangles, const Matrix4& X_CO, int id) {
  if (id < 0 || id > 32767) throw nb::value_error("id must be 0 to 32767");
  const auto n = static_cast<std::int32_t>(vertices_O.shape(0));
  const std::span<const std::int32_t> indices{triangles.data(), triangles.size()};
  for (const std::int32_t k : indices)
    if (k < 0 || k >= n) throw nb::value_error("a triangle names a vertex that does not exist");
  const Pose X = to_pose(X_CO, "X_CO");
  const nb::gil_scoped_release release;
  image.draw({vertices_O.data(), vertices_O.size()}, indices, X, static_cast<std::int16_t>(id));
}

/// A copy of the values of all pixels, of shape (rows, columns).
template <class T>
ArrayOf<T> pixels(const DepthImage& image, std::span<const T> values) {
  return array(std::vector<T>(values.begin(), values.end()),
               {static_cast<std::size_t>(image.lens().rows), static_cast<std::size_t>(image.lens().columns)});
}

}  // namespace

void bind_camera(nb::module_& m) {
  nb::class_<DepthImage>(m, "DepthImage",
                         "The nearest surface in every pixel of a pinhole camera with the optical frame C of ROS "
                         "(z forward, x right, y down). Pixel (0, 0) has its centre at the image coordinates (0, 0).")
      .def(
          "__init__",
          [](DepthImage* self, int columns, int rows, double fx, double fy, double cx, double cy, double near) {
            new (self) DepthImage(Pinhole{columns, rows, fx, fy, cx, cy, near});
          },
          "columns"_a, "rows"_a, "fx"_a, "fy"_a, "cx"_a, "cy"_a, "near"_a,
          "Focal lengths and principal point [pixel], smallest depth that is drawn [m].")
      .def("clear", &DepthImage::clear, "Remove everything that was drawn.")
      .def("draw", &draw, "vertices_O"_a, "triangles"_a, "X_CO"_a, "id"_a,
           "Draw a mesh with vertices (n,3) [m] and triangles (m,3) at the pose X_CO (4,4), as object `id`.")
      .def(
          "inverse_depth", [](const DepthImage& self) { return pixels<float>(self, self.inverse_depth()); },
          "Inverse depth 1/z (rows, columns); 0 where nothing was drawn [1/m].")
      .def(
          "cosine",
          [](const DepthImage& self) {
            const std::vector<float> values = self.cosine();
            return pixels<float>(self, values);
          },
          "Cosine of the angle between ray and normal (rows, columns); 0 where nothing was drawn [-].")
      .def(
          "object", [](const DepthImage& self) { return pixels<std::int16_t>(self, self.object()); },
          "Object drawn in every pixel (rows, columns); -1 where nothing was drawn.");
}

}  // namespace palpate::bindings
