// A table of text in columns, for people; machines take --json.
#pragma once

#include <string>
#include <vector>

namespace salvo::cli {

class TextTable {
 public:
  /// A heading that begins with '<' aligns its column to the left; the others go to the right.
  explicit TextTable(std::vector<std::string> headings);
  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<bool> left_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace salvo::cli
