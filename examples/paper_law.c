/* The paper's outer loop (Eq. 12) in C: the same states, bit for bit, as the built-in controller.
 *
 *     cargo build --release -p slipstream-c
 *     cc examples/paper_law.c -o paper_law -I agents/c -L target/release -lslipstream_c -Wl,-rpath,$PWD/target/release -lm
 *     slipstream run platoon --agent ./paper_law
 */
#include <math.h>

#include "slipstream.h"

/* Keys controller.NAME.… of the experiment: the gains of Eq. 12. */
struct gains {
    double k_x, k_y, k_theta;
};

static struct gains gains;

static int outer(void *state, const slipstream_outer_input *now, double desired[2]) {
    const struct gains *k = state;
    const double v_r = now->reference_velocity[0], w_r = now->reference_velocity[1];
    const double e_x = now->error[0], e_y = now->error[1], e_theta = now->error[2];
    desired[0] = v_r * cos(e_theta) + k->k_x * e_x;
    desired[1] = w_r + v_r * (k->k_y * e_y + k->k_theta * sin(e_theta));
    return 0;
}

static int make(const slipstream_context *context, slipstream_controller *controller) {
    gains.k_x = slipstream_number(context, "k_x", 1.0);
    gains.k_y = slipstream_number(context, "k_y", 15.0);
    gains.k_theta = slipstream_number(context, "k_theta", 6.0);
    controller->state = &gains;
    controller->outer = outer;
    return 0;
}

int main(int argc, char **argv) { return slipstream_run_agent(argc, argv, make); }
