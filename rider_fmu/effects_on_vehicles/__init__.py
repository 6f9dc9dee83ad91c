"""What a rider does to a vehicle besides his hands at its handlebar: effects that the gap workflow tries on vehicles."""
