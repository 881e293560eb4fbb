// What contacts remember: the displacements of their springs, from the first overlap to the last.
// While particles are stepped, they lie beside the lists, task by task. Lists come and go; in
// between, and while somebody looks, they lie row by row, which is what checkpoints keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "models/contact_law.hpp"
#include "soa/array.hpp"
#include "soa/table.hpp"
#include "solver/contact_pass.hpp"
#include "solver/neighbor_lists.hpp"
#include "solver/parallel.hpp"
#include "solver/wall_lists.hpp"

namespace salvo::solver {

template <class T>
class ContactMemory {
 public:
  ContactMemory(const models::ContactLaw& law, const Parallel& parallel)
      : law_(law), parallel_(parallel) {}

  /// Takes over a table of contacts, sorted by ids, between rows that are sorted by `ids`. Throws
  /// std::invalid_argument where they are not, or one is of a particle that is not there.
  void load(const soa::Table& contacts, std::span<const soa::Id> ids, std::size_t rows);
  /// Appends the contacts of the rows that live to an empty table. `row_of` is the row of each
  /// place by id, and `lives` says who does.
  void store(std::span<const soa::Id> ids, std::span<const std::uint32_t> row_of,
             std::span<const std::uint8_t> lives, soa::Table& contacts) const;

  /// Moves all out of the lists, in the order of the rows; nothing where it is there already.
  void collect(const SlotLists& lists, const WallLists<T>& walls,
               const soa::Array<std::uint32_t>& rank);
  /// Gives back what the lists had, once it is collected and they are no longer used.
  void release_listed() {
    for (TaskHistory& history : history_) history.numbers = {};
  }
  /// Follows rows that were moved, in between.
  void move_rows(const soa::Array<std::uint32_t>& source);
  /// Puts it into new lists.
  void recall(const SlotLists& lists, WallLists<T>& walls, const soa::Array<std::uint32_t>& rank);
  /// Gives back what was collected: the lists, which have not changed since, have it all.
  void release_collected() {
    entries_.release();
    partner_.release();
    tangential_.release();
    rolling_.release();
    collected_ = false;
  }

  /// The part of a task in a step, and what came of it. `after` is of as many columns of `room`.
  ContactHistory<T> history(std::size_t task, T* after, std::size_t room);
  void take(std::size_t task, const ContactHistory<T>& stepped);
  /// Numbers that a contact remembers.
  std::size_t columns() const { return law_.rolls() ? 6 : law_.remembers() ? 3 : 0; }

 private:
  static constexpr std::uint32_t wall_flag = std::uint32_t{1} << 31;

  // Of the contacts of one task, in the order of the slots and lanes.
  struct TaskHistory {
    std::vector<T> numbers;  // columns
    std::size_t contacts = 0;
    std::size_t room = 0;  // numbers that there has been room for

    void resize(std::size_t count, std::size_t columns) {
      if (count * columns > room) room = columns * (count + count / 8 + 1);
      if (numbers.capacity() < room) {
        numbers = {};
        numbers.reserve(room);
      }
      numbers.resize(columns * count);
      contacts = count;
    }
  };

  // Of a row, within what is collected.
  struct Entries {
    std::uint32_t first = 0;
    std::uint32_t last = 0;  // at first their number, and then up to where they are filled in
  };

  void share_out();
  void recall_row(const SlotLists& lists, WallLists<T>& walls, const std::uint32_t* rank,
                  std::size_t group, std::size_t lane, std::uint32_t* entries);

  const models::ContactLaw& law_;
  const Parallel& parallel_;

  // Beside the lists.
  soa::Array<std::uint16_t> touching_;
  std::vector<TaskHistory> history_;

  // By rows: partners in ascending order, particles before walls.
  bool collected_ = false;
  std::size_t rows_ = 0;
  soa::Array<Entries> entries_;
  soa::Array<std::uint32_t> partner_;  // rank, or wall_flag | part of a wall
  soa::Array<T> tangential_;           // three for each
  soa::Array<T> rolling_;
};

extern template class ContactMemory<float>;
extern template class ContactMemory<double>;

}  // namespace salvo::solver
