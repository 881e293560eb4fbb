#include "tests/models/contact_parity.hpp"

#include "models/contact.hpp"

namespace salvo::tests::contact_parity {
inline namespace SALVO_ISA {

namespace {

using kernels::Motion;
using kernels::Vec3;
using models::ContactResponse;

template <class V>
Motion<V> load(const Columns<typename V::Real>& columns, std::size_t at) {
  const auto column = [&](std::size_t i) { return V::load(columns.state[i] + at); };
  return {{column(0), column(1), column(2)}, {column(3), column(4), column(5)}};
}

template <class V>
void store(const Motion<V>& m, const Columns<typename V::Real>& columns, std::size_t at) {
  m.position.x.store(columns.state[0] + at);
  m.position.y.store(columns.state[1] + at);
  m.position.z.store(columns.state[2] + at);
  m.velocity.x.store(columns.state[3] + at);
  m.velocity.y.store(columns.state[4] + at);
  m.velocity.z.store(columns.state[5] + at);
}

template <class T>
void run(const Run<T>& r) {
  using V = kernels::NativeLane<T>;
  const models::Contact<V> contact(r.obstacles, r.settings);
  const V dt(r.dt);
  const V half = dt * V(0.5);
  for (std::size_t at = 0; at < r.rows; at += V::width) {
    const models::ParticleRow<V> row{V::load(r.mass + at), V::load(r.radius + at), V(0)};
    const auto active = V::load(r.active + at) != V(0);
    models::ContactCount<V> count;
    const auto fall = [&](const Motion<V>& m) -> Motion<V> {
      const Vec3<V> end{m.velocity.x, m.velocity.y - V(r.gravity) * dt, m.velocity.z};
      return {m.position + (m.velocity + end) * half, end};
    };
    Motion<V> m = load<V>(r.before, at);
    for (int n = 0; n < r.steps; ++n) {
      switch (r.settings.response) {
        case ContactResponse::swept:
          m = contact.resolve(m, r.after ? load<V>(*r.after, at) : fall(m), row, dt, active, count);
          break;
        case ContactResponse::impulse:
          m = fall(contact.respond(m, row, active, count));
          break;
        case ContactResponse::force: {
          const auto hit = contact.book_force(m, row, dt, active, count);
          m = select(hit.mask, hit.motion, fall(m));
          break;
        }
      }
    }
    store(m, r.result, at);
    count.impacts.store(r.impacts + at);
    count.rests.store(r.rests + at);
  }
}

}  // namespace

extern const Table test_table;
const Table test_table{&run<float>, &run<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::tests::contact_parity
