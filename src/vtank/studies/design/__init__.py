"""Before the tank is booked: what a plan of experiments can tell, how well the estimators use it, and a better plan."""
