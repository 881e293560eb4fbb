// What all rows of a batch share beyond numbers, such as a table. A model that has some says
//
//   using Data = ...;                    // derived from ModelData
//   explicit Model(const Data& data);    // beside the constructor without it
#pragma once

#include <span>

namespace salvo::models {

class ModelData {
 public:
  ModelData() = default;
  ModelData(const ModelData&) = delete;
  ModelData& operator=(const ModelData&) = delete;
  virtual ~ModelData();  // in a source: its type is one for all instruction sets
  /// What decides the bits of a row: equal data have equal numbers.
  virtual std::span<const double> numbers() const = 0;
};

}  // namespace salvo::models
