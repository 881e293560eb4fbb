#include "models/model_data.hpp"

namespace salvo::models {

ModelData::~ModelData() = default;

}  // namespace salvo::models
