/// @file
/// One visitor of several functions, for std::visit.
#pragma once

namespace leadline::app {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

}  // namespace leadline::app
