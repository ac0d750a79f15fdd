# From the stacks of `agent_node train` as inferno-collapse-perf prints them to those of the profile
# in performance.md.

# The threads that work for a step, under names that say what they do; the others are left out.
s/^agent_node;.*Training::run/the learner/
s/^environment;.*begin_short_backtrace/the thread that speaks with the room/
s/^RustDDS_Partici;.*DPEventLoop::event_loop/RustDDS's event loop/
/^(the learner|the thread that speaks with the room|RustDDS's event loop)[; ]/!d

# The functions of the kernel and of pulp's dispatch are one frame each.
s/;(entry_SYSCALL_64|asm_)[^ ]*( [0-9]+)$/;kernel\2/
s/;(__libc_[a-z]+|__GI_+[a-z_]+);kernel/;kernel/
s/pulp::[a-zA-Z0-9:]+::vectorize::imp(_fastcall)?/vectorized/g
s/<([a-zA-Z_:]+) as pulp::WithSimd>::with_simd/\1/g

# Names without their modules.
s/(agent_node|ros_runtime|rustdds|mio)::([a-z_0-9]+::)*//g
