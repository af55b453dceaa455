// Docstrings of fields: `.def_rw("t", &Tick::t, "Time [s]."_doc)`.
#pragma once

#include <cstddef>

namespace palpate::bindings {

/// The text as a pointer: given arrays, nanobind compiles a getter and a setter for each length of text in a class, not
/// for each type of field.
constexpr const char* operator""_doc(const char* text, std::size_t) { return text; }

}  // namespace palpate::bindings
