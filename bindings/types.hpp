// Types of arguments and results: arrays that a function reads in place, and return types that name the types inside
// arrays, tuples and dicts, for the stub generator (tools/stubs.py). Every file of bindings includes this header, since
// a file that lacks a converter of nanobind compiles, but fails when the module is imported.
#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

namespace palpate::bindings {

template <class T>
using ArrayOf = nanobind::typed<nanobind::object, nanobind::ndarray<nanobind::numpy, T>>;
using Array = ArrayOf<double>;
template <class... T>
using Tuple = nanobind::typed<nanobind::tuple, T...>;
using Fields = nanobind::typed<nanobind::dict, nanobind::str, nanobind::any>;

/// An array that a function reads where it lies; -1: any length.
template <class T, nanobind::ssize_t... Shape>
using Input = nanobind::ndarray<const T, nanobind::shape<Shape...>, nanobind::c_contig, nanobind::device::cpu>;
using Points = Input<double, -1, 3>;
using Triangles = Input<std::int32_t, -1, 3>;
using Poses = Input<double, -1, 4, 4>;
using Times = Input<double, -1>;

/// A numpy array with rows and columns.
using Table = nanobind::ndarray<nanobind::numpy, double, nanobind::ndim<2>>;

/// A numpy array of this shape that owns its values.
template <class T>
ArrayOf<T> array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
  auto* owned = new std::vector<T>(std::move(values));
  nanobind::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return ArrayOf<T>(nanobind::cast(nanobind::ndarray<nanobind::numpy, T>(owned->data(), shape, owner)));
}

}  // namespace palpate::bindings
